"""Stereo pairs from live cameras through real topics."""

from __future__ import annotations

import math
import threading
from argparse import Namespace
from dataclasses import replace
from threading import Event, Thread
from typing import Any, Self

import numpy as np
import pytest
import rclpy
from geometry_msgs.msg import Quaternion
from node_testing import IsolatedGraph
from place_scenes import MOUNT
from rclpy.node import Node
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import Header
from taught_wall import CALIBRATIONS, HERE, RAW, RIG, TAUGHT, raw_image, seen

from shirube_ros.camera.image import image_from_array
from stereo_landmark.commands.teach import make_parser
from stereo_landmark.core.pair.camera_pair import CameraCalibration
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.page.live_pairs import CameraSubscriber, LivePairs, live_pairs

SIDES = ('left', 'right')
TILT = (0.03, -0.02)


class Cameras:
    """Publishes stereo pairs repeatedly within the context."""

    def __init__(self, graph: IsolatedGraph, state: tuple[float, ...] | None = TAUGHT) -> None:
        self.node = graph.add(lambda **options: Node('cameras', **options))
        self.listener = graph.add(lambda **options: Node('listener', **options))
        self.state = state
        self._graph, self._end, self._stamp = graph, Event(), 0
        self.tilt = TILT
        self._imu = self.node.create_publisher(Imu, 'imu', 5)
        self.calibrations = CALIBRATIONS
        self.raw: Any = None
        self._images = [self.node.create_publisher(Image, f'{side}/image_rect', 5) for side in SIDES]
        self._infos = [self.node.create_publisher(CameraInfo, f'{side}/camera_info', 5) for side in SIDES]
        self._thread = Thread(target=self._work)

    def __enter__(self) -> Self:
        self.subscriber = CameraSubscriber(self.listener, 'raw', 0.0)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()

    def restart(self) -> None:
        """Restart the stamps, like a bag or simulation that starts again."""
        self._stamp = 0

    def _work(self) -> None:
        while not self._end.is_set():
            if self.raw is not None:
                self._publish(self.raw)
            elif self.state is not None:
                self._publish(seen(self.state))
            self._graph.spin_until(self._end.is_set, 0.05)

    def _publish(self, images: Any) -> None:
        self._stamp += 1
        header = Header(frame_id='camera')
        header.stamp.sec = self._stamp
        self._imu.publish(imu_of(self.tilt, header))
        self._graph.spin_until(self._end.is_set, 0.02)
        for number, image in enumerate(images):
            self._infos[number].publish(info_of(self.calibrations[number], header))
            self._images[number].publish(image_from_array(image, header))


def imu_of(tilt: tuple[float, float], header: Header) -> Imu:
    x, y, z, w = Rotation.from_euler('xyz', (*tilt, 0.0)).as_quat().tolist()
    return Imu(header=header, orientation=Quaternion(x=x, y=y, z=z, w=w))


def info_of(calibration: CameraCalibration, header: Header) -> CameraInfo:
    camera = calibration.raw
    return CameraInfo(
        header=header, width=camera.width, height=camera.height, distortion_model='plumb_bob',
        d=list(camera.distortion), k=camera.matrix.ravel().tolist(), r=list(calibration.rotation),
        p=list(calibration.projection),
    )  # fmt: skip


def test_each_picture_is_what_the_cameras_see_now(graph: IsolatedGraph) -> None:
    with Cameras(graph) as cameras:
        pairs = LivePairs(cameras.subscriber, MOUNT, rectify=False)
        assert pairs.rig == RIG
        assert np.array_equal(pairs.images(0).left, seen(TAUGHT)[0])
        cameras.state = HERE
        # One pair may still be queued.
        numbers = [pairs.capture(), pairs.capture()]
        assert numbers == [1, 2]
        assert np.array_equal(pairs.images(2).right, seen(HERE)[1])
        assert len(pairs.labels) == 3
        assert pairs.images(2).tilt == pytest.approx(TILT)
        assert math.isclose(pairs.rig.baseline, 0.2)


def test_pictures_have_the_tilt_of_their_moment_and_go_on_when_time_jumps_back(graph: IsolatedGraph) -> None:
    with Cameras(graph) as cameras:
        pairs = LivePairs(cameras.subscriber, MOUNT, rectify=False)
        cameras.tilt = (0.02, 0.0)
        pairs.capture()
        number = pairs.capture()
        assert pairs.images(number).tilt == pytest.approx((0.02, 0.0), abs=1e-9)
        cameras.restart()
        cameras.tilt = (-0.01, 0.0)
        pairs.capture()
        number = pairs.capture()
        assert pairs.images(number).tilt == pytest.approx((-0.01, 0.0), abs=1e-9)


def test_a_changed_calibration_is_reported(graph: IsolatedGraph) -> None:
    with Cameras(graph) as cameras:
        pairs = LivePairs(cameras.subscriber, MOUNT, rectify=False)
        shifted = replace(CALIBRATIONS[0], raw=replace(CALIBRATIONS[0].raw, cx=190.0))
        cameras.calibrations = (shifted, CALIBRATIONS[1])
        with pytest.raises(StereoLandmarkError, match='calibration of the cameras changed; restart teach'):
            # One pair may still be queued.
            _ = [pairs.capture() for _ in range(2)]


def test_raw_live_images_are_rectified(graph: IsolatedGraph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('stereo_landmark.page.live_pairs.FIRST_PAIR_TIMEOUT', 60.0)
    raw = [raw_image(image, calibration) for image, calibration in zip(seen(TAUGHT), RAW, strict=True)]
    with Cameras(graph, None) as cameras:
        cameras.calibrations = RAW
        cameras.raw = raw
        pair = LivePairs(cameras.subscriber, MOUNT, rectify=True).images(0)
    inside = np.s_[30:-30, 40:-40]
    assert np.abs(pair.left[inside].astype(float) - seen(TAUGHT)[0][inside]).mean() < 4.0


def test_silent_cameras_are_reported(graph: IsolatedGraph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('stereo_landmark.page.live_pairs.FIRST_PAIR_TIMEOUT', 0.3)
    silent = pytest.raises(StereoLandmarkError, match=r'no stereo pair was received within 0\.3 s')
    with Cameras(graph, None) as cameras, silent:
        LivePairs(cameras.subscriber, MOUNT, rectify=False)


def test_nothing_runs_on_when_the_page_has_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('stereo_landmark.page.live_pairs.FIRST_PAIR_TIMEOUT', 0.2)
    before = set(threading.enumerate())
    options = make_parser().parse_args(['--live'], Namespace(ros_args=[]))
    with pytest.raises(StereoLandmarkError, match='no stereo pair'), live_pairs(options, MOUNT):
        pass
    assert set(threading.enumerate()) <= before
    assert not rclpy.ok()
