"""Stereo pairs of live cameras for the page, captured on request."""

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

from shirube_core.geometry import CameraMount, TiltBuffer
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.image import to_grey
from shirube_ros.camera.input import ImageInput
from shirube_ros.message_conversion import tilt_from_imu
from shirube_ros.quality_of_service import odometry_profile
from shirube_ros.stamps import StampValidator
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Side, StampSynchronizer, stereo_rig
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import calibration_from_camera_info
from stereo_landmark.page.pair_source import StereoPairs

FIRST_PAIR_TIMEOUT = 30.0
"""Timeout for the first pair [s]."""
_PAIR_TIMEOUT = 5.0
"""Timeout for a requested pair [s]."""
_TILT_TIMEOUT = 0.3
"""Timeout for the imu message of a pair, which may arrive after the images [s]."""
_QUEUE_SIZE = 10
_NANOSECONDS = 1_000_000_000

_CalibratedImage = tuple[int, NDArray[np.uint8], CameraCalibration]


class CameraSubscriber:
    """Subscribes to both cameras and the imu.

    Args:
        node: node that subscribes to ``left/image_rect``, ``left/camera_info``, their ``right`` topics, and ``imu``.
        transport: image transport: raw, compressed or auto.
        tolerance: maximum difference between the stamps of a pair [s].
    """

    def __init__(self, node: Node, transport: str, tolerance: float) -> None:
        self._tolerance_ns = round(tolerance * 1e9)
        self._stamps = StampValidator(self._reset)
        # Lock for the members below: messages arrive in another thread.
        self._condition = Condition()
        self._latest: tuple[_CalibratedImage, _CalibratedImage] | None = None
        self._has_imu = False
        self._reset()
        guard = CallbackGuard(node, (StereoLandmarkError,))
        for side in Side:
            name = side.name.lower()
            ImageInput(
                node,
                guard,
                (f'{name}/image_rect', f'{name}/camera_info'),
                transport,
                calibration_from_camera_info,
                partial(self._add_image, side),
            )
        node.create_subscription(Imu, 'imu', guard.guard('imu', self._add_imu), odometry_profile())

    def next_pair(self, timeout: float) -> tuple[StereoImages, tuple[CameraCalibration, CameraCalibration]]:
        """Wait for the next pair.

        Args:
            timeout: timeout [s].

        Raises:
            StereoLandmarkError: no pair was received, or the imu has no message for its stamp.
        """
        with self._condition:
            self._latest = None
            self._condition.wait_for(lambda: self._latest is not None, timeout)
            latest = self._latest
            if latest is None:
                raise StereoLandmarkError(
                    f'no stereo pair was received within {timeout:g} s; are left/image_rect, right/image_rect and '
                    'their camera_info published, with equal stamps?'
                )
            (stamp_ns, left, left_calibration), (_, right, right_calibration) = latest
            tilt = self._tilt_at(stamp_ns * 1e-9)
        return StereoImages(left, right, tilt), (left_calibration, right_calibration)

    def _tilt_at(self, stamp: float) -> tuple[float, float]:
        """Return roll and pitch of the robot [rad], zero without an imu."""
        if not self._has_imu:
            return 0.0, 0.0
        self._condition.wait_for(lambda: self._tilts.tilt_at(stamp) is not None, _TILT_TIMEOUT)
        tilt = self._tilts.tilt_at(stamp)
        if tilt is None:
            raise StereoLandmarkError(
                'no imu message near the stamp of the images; compare the stamps of imu and images'
            )
        return tilt

    def _reset(self) -> None:
        """Reset buffers after the clock jumped back."""
        self._pairing: StampSynchronizer[_CalibratedImage] = StampSynchronizer(self._tolerance_ns, _QUEUE_SIZE)
        self._tilts = TiltBuffer()

    def _add_image(self, side: Side, header: Header, pixels: NDArray[np.uint8], calibration: CameraCalibration) -> None:
        stamp_ns = header.stamp.sec * _NANOSECONDS + header.stamp.nanosec
        image = to_grey(pixels)
        with self._condition:
            self._stamps.check(header, f'{side.name.lower()}/image_rect')
            pair = self._pairing.add(side, stamp_ns, (stamp_ns, image, calibration))
            if pair is not None:
                self._latest = pair
                self._condition.notify_all()

    def _add_imu(self, message: Any) -> None:
        roll, pitch = tilt_from_imu(message, 'imu')
        with self._condition:
            stamp = self._stamps.check(message.header, 'imu')
            self._tilts.add(stamp, roll, pitch)
            self._has_imu = True
            self._condition.notify_all()


class LivePairs(StereoPairs):
    """Stereo pairs captured from the page.

    Args:
        listener: camera subscriber.
        mount: extrinsics of the left camera's rectified optical frame on the robot.
        rectify: whether the images are raw and have to be rectified.

    Raises:
        StereoLandmarkError: no images are received, or the calibrations are not those of a stereo pair.
    """

    is_live = True

    def __init__(self, listener: CameraSubscriber, mount: CameraMount, *, rectify: bool) -> None:
        self._listener = listener
        self._captured: list[StereoImages] = []
        self._labels: list[str] = []
        first, self._calibrations = listener.next_pair(FIRST_PAIR_TIMEOUT)
        rig = stereo_rig(*self._calibrations, mount)
        raw = self._calibrations if rectify else None
        super().__init__(self._labels, self._captured.__getitem__, rig, raw)
        self._add(first)

    def capture(self) -> int:
        """Capture a pair and return its number.

        Raises:
            StereoLandmarkError: no images are received, or the calibration changed.
        """
        images, calibrations = self._listener.next_pair(_PAIR_TIMEOUT)
        if calibrations != self._calibrations:
            raise StereoLandmarkError('the calibration of the cameras changed; restart teach')
        return self._add(images)

    def _add(self, images: StereoImages) -> int:
        self._captured.append(images)
        self._labels.append(f'captured {datetime.now().astimezone():%H:%M:%S}')
        return len(self._captured) - 1


@contextmanager
def live_pairs(options: argparse.Namespace, mount: CameraMount) -> Iterator[LivePairs]:
    """Subscribe to the cameras within the context.

    Raises:
        StereoLandmarkError: no images are received, or the calibrations are not those of a stereo pair.
    """
    # Signals are handled by the page server, which exits this context.
    rclpy.init(args=options.ros_args, signal_handler_options=SignalHandlerOptions.NO)
    node = Node('stereo_landmark_teach')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    thread = Thread(target=_spin, args=(executor.spin,), daemon=True)
    try:
        listener = CameraSubscriber(node, options.image_transport, options.approximate_sync or 0.0)
        thread.start()
        yield LivePairs(listener, mount, rectify=options.rectify)
    finally:
        executor.shutdown()
        if thread.is_alive():
            thread.join(_PAIR_TIMEOUT)
        node.destroy_node()
        rclpy.try_shutdown()


def _spin(spin: Callable[[], None]) -> None:
    try:
        spin()
    except ExternalShutdownException:
        return
