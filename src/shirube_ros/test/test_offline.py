"""A recording yields valid messages in order, bad images with their error; after a jump back, a new localizer."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from node_testing import header
from sensor_msgs.msg import CameraInfo, CompressedImage, Imu

from shirube_core.geometry import SE2
from shirube_ros.camera.image import image_from_array
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.message_conversion import odometry_message
from shirube_ros.offline.locate import OfflineLocalizer, locate_recording
from shirube_ros.offline.recording import (
    BadImage,
    RecordedImage,
    RecordedOdometry,
    RecordedTilt,
    Recording,
    RecordingTopics,
)

TOPICS = RecordingTopics(('/left', '/right'), ('/left/info', '/right/info'), '/odom', '/imu')
PIXELS = np.arange(12, dtype=np.uint8).reshape(3, 4)


def info(width=4, focal_length=100.0):
    matrix = [focal_length, 0.0, 1.5, 0.0, focal_length, 1.0, 0.0, 0.0, 1.0]
    return CameraInfo(header=header(0), width=width, height=3, k=matrix, distortion_model='plumb_bob')


def image(stamp, pixels=PIXELS):
    return image_from_array(pixels, header(stamp))


def compressed(stamp):
    data = cv2.imencode('.png', PIXELS)[1].tobytes()
    return CompressedImage(header=header(stamp), format='png', data=data)


def odometry(stamp):
    return odometry_message(SE2(1.0, 2.0, 0.5), np.eye(3), header(stamp), 'base_link')


class Rows:
    """A bag of (topic, message) rows."""

    def __init__(self, rows):
        self.rows = rows

    def messages(self, wanted):
        for topic, message in self.rows:
            if topic in wanted:
                yield SimpleNamespace(topic=topic, msgtype=f'msg/{type(message).__name__}', message=message)

    def decode(self, row):
        return row.message


def read(*rows, topics=TOPICS):
    return list(Recording(Rows(rows), topics, camera_from_camera_info).messages())


def test_everything_comes_in_its_order():
    received = read(
        ('/left/info', info()),
        ('/right/info', info()),
        ('/odom', odometry(1.0)),
        ('/left', image(1.5)),
        ('/imu', Imu(header=header(1.75))),
        ('/right', compressed(2.0)),
        ('/other', odometry(3.0)),
    )
    assert [type(one) for one in received] == [RecordedOdometry, RecordedImage, RecordedTilt, RecordedImage]
    wheels, left, tilt, right = received
    assert wheels.T_odom_base.distance_to(SE2(1.0, 2.0, 0.5)) < 1e-12
    assert tilt.tilt == (0.0, 0.0)
    assert [(one.camera, one.topic, one.stamp_ns) for one in (left, right)] == [
        (0, '/left', 1_500_000_000),
        (1, '/right', 2_000_000_000),
    ]
    assert tilt.stamp_ns == 1_750_000_000
    for one in (left, right):
        np.testing.assert_array_equal(one.pixels, PIXELS)
        assert one.calibration.fx == 100.0


def test_each_camera_has_its_own_calibration_and_the_newest():
    received = read(
        ('/left/info', info(focal_length=100.0)),
        ('/right/info', info(focal_length=200.0)),
        ('/left', image(1)),
        ('/right', image(1)),
        ('/left/info', info(focal_length=300.0)),
        ('/left', image(2)),
    )
    assert [one.calibration.fx for one in received] == [100.0, 200.0, 300.0]


@pytest.mark.parametrize(
    ('rows', 'fault'),
    [
        ([('/left', image(1))], '/left was received without a valid /left/info'),
        ([('/right/info', info()), ('/left', image(1))], '/left was received without a valid /left/info'),
        ([('/left/info', info(width=8)), ('/left', image(1))], '/left is 4 x 3 px but /left/info is for 8 x 3 px'),
        ([('/left/info', info()), ('/left', CompressedImage(header=header(1), data=b'no'))], '/left'),
    ],
)  # fmt: skip
def test_a_bad_image_has_its_error(rows, fault):
    (bad,) = read(*rows)
    assert isinstance(bad, BadImage)
    assert (bad.topic, bad.stamp_ns) == ('/left', 1_000_000_000)
    assert bad.fault.startswith(fault)


def test_after_a_bad_calibration_the_one_before_counts_no_more():
    received = read(('/left/info', info()), ('/left/info', info(focal_length=0.0)), ('/left', image(1)))
    assert [type(one) for one in received] == [BadImage]


def test_bad_odometry_and_tilt_are_left_out():
    bad = odometry(1)
    bad.pose.pose.position.x = float('nan')
    invalid = Imu(header=header(1))
    invalid.orientation.w = 0.0
    assert not read(('/odom', bad), ('/imu', invalid))


def test_a_method_without_odometry_sees_none():
    topics = RecordingTopics(('/left',), ('/left/info',))
    assert topics.wanted == ['/left', '/left/info']
    assert not read(('/odom', odometry(1)), ('/imu', Imu(header=header(1))), topics=topics)


def test_messages_after_a_jump_back_go_to_the_new_localizer():
    rows = [('/odom', odometry(stamp)) for stamp in (100, 2, 3, 4, 5, 6, 7)]
    rows += [('/imu', Imu(header=header(stamp))) for stamp in (8, 1, 2, 3, 4, 5)]
    taken = []

    def create():
        taken.append(stamps := [])
        note = lambda stamp, *_: stamps.append(stamp)  # noqa: E731
        return OfflineLocalizer(lambda *_: None, note, note)

    assert not list(locate_recording(Recording(Rows(rows), TOPICS, camera_from_camera_info), create, ()))
    assert taken == [[100.0], [6.0, 7.0, 8.0], [5.0]]
