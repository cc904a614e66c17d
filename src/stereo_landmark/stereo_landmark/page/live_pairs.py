"""Pairs of the robot's own cameras for the page: what they see at the push of a button."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from functools import partial
from threading import Condition, Thread
from typing import Any

import numpy as np
import rclpy
from numpy.typing import NDArray
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from shirube_geometry import CameraMount, TiltTrail
from shirube_ros.image_input import ImageInput
from shirube_ros.message_guard import MessageGuard
from shirube_ros.quality_of_service import odometry_profile
from shirube_ros.stamp_order import StampOrder
from shirube_ros.tilt_conversion import tilt_of_imu
from stereo_landmark.calibration_message import calibration_from_camera_info
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, stereo_rig
from stereo_landmark.core.pair.pair_stream import Side
from stereo_landmark.core.pair.stamp_pairing import StampPairing
from stereo_landmark.core.pair.stereo_images import StereoImages
from stereo_landmark.core.place.stereo_rig import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.grey_image import grey
from stereo_landmark.page.pair_source import RecordedPairs

FIRST_WAIT = 30.0
"""For the first pair [s]."""
_WAIT = 5.0
"""For a picture that was asked for [s]."""
_TILT_WAIT = 0.3
"""For what the imu said at the moment of a pair: its messages may come after the images [s]."""
_QUEUE = 10
_NANOSECONDS = 1_000_000_000

_Seen = tuple[int, NDArray[np.uint8], CameraCalibration]


class CameraListener:
    """Listens to both cameras and the imu.

    Args:
        node: that subscribes to ``left/image_rect``, ``left/camera_info``, the same of ``right``, and ``imu``.
        transport: of the images: raw, compressed or auto.
        tolerance: stamps of a pair differ by no more [s].
    """

    def __init__(self, node: Node, transport: str, tolerance: float) -> None:
        self._tolerance_ns = round(tolerance * 1e9)
        self._stamps = StampOrder(self._start_again)
        # Held by who touches what is below: messages come in a thread of their own.
        self._news = Condition()
        self._latest: tuple[_Seen, _Seen] | None = None
        self._has_imu = False
        self._start_again()
        guard = MessageGuard(node, (StereoLandmarkError,))
        for side in Side:
            name = side.name.lower()
            ImageInput(
                node,
                guard,
                (f'{name}/image_rect', f'{name}/camera_info'),
                transport,
                calibration_from_camera_info,
                partial(self._take, side),
            )
        node.create_subscription(Imu, 'imu', guard.guard('imu', self._take_imu), odometry_profile())

    def next_pair(self, timeout: float) -> tuple[StereoImages, tuple[CameraCalibration, CameraCalibration]]:
        """Wait for a pair that is taken from now on.

        Args:
            timeout: how long [s].

        Raises:
            StereoLandmarkError: none came, or an imu that was heard says nothing of its moment.
        """
        with self._news:
            self._latest = None
            self._news.wait_for(lambda: self._latest is not None, timeout)
            latest = self._latest
            if latest is None:
                raise StereoLandmarkError(
                    f'no pair of images came within {timeout:g} s; are left/image_rect, right/image_rect and '
                    'their camera_info published, with equal stamps?'
                )
            (stamp_ns, left, left_calibration), (_, right, right_calibration) = latest
            tilt = self._tilt_at(stamp_ns * 1e-9)
        return StereoImages(left, right, tilt), (left_calibration, right_calibration)

    def _tilt_at(self, stamp: float) -> tuple[float, float]:
        """Return how the robot leaned [rad], level where there is no imu."""
        if not self._has_imu:
            return 0.0, 0.0
        self._news.wait_for(lambda: self._tilts.tilt_at(stamp) is not None, _TILT_WAIT)
        tilt = self._tilts.tilt_at(stamp)
        if tilt is None:
            raise StereoLandmarkError(
                'the imu says nothing of the moment of the images; compare its stamps with theirs'
            )
        return tilt

    def _start_again(self) -> None:
        """Forget what came before: time jumped back."""
        self._waiting: StampPairing[_Seen] = StampPairing(self._tolerance_ns, _QUEUE)
        self._tilts = TiltTrail()

    def _take(
        self, side: Side, header: Header, pixels: NDArray[np.uint8], calibration: CameraCalibration
    ) -> None:
        stamp_ns = header.stamp.sec * _NANOSECONDS + header.stamp.nanosec
        image = grey(pixels)
        with self._news:
            self._stamps.check(header, f'{side.name.lower()}/image_rect')
            pair = self._waiting.add(side, stamp_ns, (stamp_ns, image, calibration))
            if pair is not None:
                self._latest = pair
                self._news.notify_all()

    def _take_imu(self, message: Any) -> None:
        roll, pitch = tilt_of_imu(message, 'imu')
        with self._news:
            stamp = self._stamps.check(message.header, 'imu')
            self._tilts.add(stamp, roll, pitch)
            self._has_imu = True
            self._news.notify_all()


class LivePairs:
    """Pictures that the engineer took from the page.

    Args:
        listener: to the cameras.
        mount: the left camera's optical frame, as rectified, on the robot.
        rectify: whether the images come raw.

    Raises:
        StereoLandmarkError: the cameras are silent, or their calibrations are no pair's.
    """

    is_live = True

    def __init__(self, listener: CameraListener, mount: CameraMount, *, rectify: bool) -> None:
        self._listener = listener
        self._taken: list[StereoImages] = []
        self.labels: list[str] = []
        first, self._calibrations = listener.next_pair(FIRST_WAIT)
        self._recorded = RecordedPairs(
            self.labels,
            self._taken.__getitem__,
            stereo_rig(*self._calibrations, mount),
            self._calibrations if rectify else None,
        )
        self._add(first)

    @property
    def rig(self) -> StereoRig:
        """The rectified cameras."""
        return self._recorded.rig

    def images(self, number: int) -> StereoImages:
        """Return a picture that was taken, rectified.

        Raises:
            StereoLandmarkError: there is none of that number, or it is no rectified pair.
        """
        return self._recorded.images(number)

    def take(self) -> int:
        """Take a picture and return its number.

        Raises:
            StereoLandmarkError: the cameras are silent, or were calibrated anew.
        """
        images, calibrations = self._listener.next_pair(_WAIT)
        if calibrations != self._calibrations:
            raise StereoLandmarkError('the cameras were calibrated anew; start teach again')
        return self._add(images)

    def _add(self, images: StereoImages) -> int:
        self._taken.append(images)
        self.labels.append(f'taken {datetime.now().astimezone():%H:%M:%S}')
        return len(self._taken) - 1


@contextmanager
def live_pairs(options: argparse.Namespace, mount: CameraMount) -> Iterator[LivePairs]:
    """Listen to the cameras while the block runs.

    Raises:
        StereoLandmarkError: the cameras are silent, or their calibrations are no pair's.
    """
    # Signals end the page, and with it this block.
    rclpy.init(args=options.ros_args, signal_handler_options=SignalHandlerOptions.NO)
    node = Node('stereo_landmark_teach')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    thread = Thread(target=_spin, args=(executor.spin,), daemon=True)
    try:
        listener = CameraListener(node, options.image_transport, options.approximate_sync or 0.0)
        thread.start()
        yield LivePairs(listener, mount, rectify=options.rectify)
    finally:
        executor.shutdown()
        if thread.is_alive():
            thread.join(_WAIT)
        node.destroy_node()
        rclpy.try_shutdown()


def _spin(spin: Callable[[], None]) -> None:
    try:
        spin()
    except ExternalShutdownException:
        return
