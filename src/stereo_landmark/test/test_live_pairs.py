"""Stereo pairs from live cameras through real topics."""

import threading
from argparse import Namespace
from dataclasses import replace
from threading import Event, Thread

import numpy as np
import pytest
import rclpy
from landmark_robot import imu, info, input_publishers
from node_testing import header
from place_scenes import MOUNT
from rclpy.node import Node
from taught_wall import CALIBRATIONS, HERE, RAW, RIG, SIDES, TAUGHT, raw_pair, seen

from shirube_ros.camera.image import image_from_array
from stereo_landmark.commands.teach import make_parser
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.page.live_pairs import CameraSubscriber, LivePairs, live_pairs


class Cameras:
    """Publishes stereo pairs repeatedly within the context."""

    def __init__(self, graph, images, calibrations=CALIBRATIONS):
        self.images, self.calibrations, self.tilt, self.stamp = images, calibrations, (0.03, -0.02), 0
        self._graph, self._end = graph, Event()
        node = graph.add(lambda **options: Node('cameras', **options))
        self._listener = graph.add(lambda **options: Node('listener', **options))
        self._publishers = input_publishers(node)
        self._thread = Thread(target=self._work)

    def __enter__(self):
        self._subscriber = CameraSubscriber(self._listener, 'raw', 0.0)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join()

    def wait_for_stamp(self, stamp):
        while self.stamp < stamp:
            self._end.wait(0.01)

    def pairs(self, *, rectify=False):
        return LivePairs(self._subscriber, MOUNT, rectify=rectify)

    def _work(self):
        while not self._end.is_set():
            self.stamp += 1
            self._publish(header(self.stamp, 'camera'))
            self._graph.spin_until(self._end.is_set, 0.05)

    def _publish(self, at):
        self._publishers['imu'].publish(imu(at, self.tilt))
        self._graph.spin_until(self._end.is_set, 0.02)
        for side, image, calibration in zip(SIDES, self.images, self.calibrations):
            self._publishers[f'{side}/camera_info'].publish(info(calibration, at))
            self._publishers[f'{side}/image_rect'].publish(image_from_array(image, at))


def capture(pairs):
    """Return a pair of now; another one may still be queued."""
    return pairs.images([pairs.capture(), pairs.capture()][1])


def test_each_picture_is_what_the_cameras_see_now_with_its_tilt_also_when_time_jumps_back(graph):
    with Cameras(graph, seen(TAUGHT)) as cameras:
        pairs = cameras.pairs()
        assert pairs.rig == RIG
        assert np.array_equal(pairs.images(0).left, seen(TAUGHT)[0])
        cameras.images, cameras.tilt = seen(HERE), (0.02, 0.0)
        now = capture(pairs)
        assert np.array_equal(now.right, seen(HERE)[1])
        assert now.tilt == pytest.approx((0.02, 0.0), abs=1e-9)
        assert len(pairs.labels) == 3
        cameras.stamp, cameras.tilt = 0, (-0.01, 0.0)
        cameras.wait_for_stamp(4)  # the first messages after a jump are dropped
        assert capture(pairs).tilt == pytest.approx((-0.01, 0.0), abs=1e-9)


def test_a_changed_calibration_is_reported(graph):
    with Cameras(graph, seen(TAUGHT)) as cameras:
        pairs = cameras.pairs()
        shifted = replace(CALIBRATIONS[0], raw=replace(CALIBRATIONS[0].raw, cx=190.0))
        cameras.calibrations = (shifted, CALIBRATIONS[1])
        with pytest.raises(StereoLandmarkError, match='calibration of the cameras changed; restart teach'):
            capture(pairs)


def test_raw_live_images_are_rectified(graph, monkeypatch):
    monkeypatch.setattr('stereo_landmark.page.live_pairs.FIRST_PAIR_TIMEOUT', 60.0)
    with Cameras(graph, raw_pair(TAUGHT), RAW) as cameras:
        pair = cameras.pairs(rectify=True).images(0)
    difference = np.abs(np.subtract(pair.left, seen(TAUGHT)[0], dtype=float))
    assert difference[30:-30, 40:-40].mean() < 4.0


def test_silent_cameras_are_reported_and_nothing_runs_on(monkeypatch):
    monkeypatch.setattr('stereo_landmark.page.live_pairs.FIRST_PAIR_TIMEOUT', 0.2)
    before = set(threading.enumerate())
    options = make_parser().parse_args(['--live'], Namespace(ros_args=[]))
    silent = pytest.raises(StereoLandmarkError, match=r'no stereo pair was received within 0\.2 s')
    with silent, live_pairs(options, MOUNT):
        pass
    assert set(threading.enumerate()) <= before
    assert not rclpy.ok()
