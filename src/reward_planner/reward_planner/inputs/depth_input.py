"""Subscription to depth images."""

from __future__ import annotations

from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

from reward_planner.core.depth.depth_points import points_from_depth_image
from reward_planner.core.navigator import SensorFrame
from reward_planner.inputs.frame_callback import FrameCallback
from shirube_core.geometry import PinholeCamera
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.image import depth_from_image
from shirube_ros.camera.info import rectified_camera
from shirube_ros.errors import CameraInfoError
from shirube_ros.quality_of_service import overridable, sensor_profile

_IMAGE, _INFO = 'depth/image', 'depth/camera_info'


class DepthInput:
    """Subscribes to ``depth/image`` (Image, 32FC1 or 16UC1) and ``depth/camera_info`` (CameraInfo)."""

    def __init__(self, node: Node, guard: CallbackGuard, on_frame: FrameCallback) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
            guard: counts the messages and catches their errors.
            on_frame: called for each valid image.
        """
        self._camera: PinholeCamera | None = None
        self._on_frame = on_frame
        for kind, topic, take in (
            (CameraInfo, _INFO, self._take_info),
            (Image, _IMAGE, self._take_image),
        ):
            node.create_subscription(
                kind,
                topic,
                guard.guard(topic, take),
                sensor_profile(),
                qos_overriding_options=overridable(),
            )

    def _take_info(self, message: CameraInfo) -> None:
        self._camera = None  # after an invalid calibration the old one must not be used
        self._camera = rectified_camera(message, _INFO)

    def _take_image(self, message: Image) -> None:
        depth = depth_from_image(message, _IMAGE)
        if self._camera is None:
            raise CameraInfoError(f'{_IMAGE} was received without a valid {_INFO}; publish the calibration')
        points = points_from_depth_image(depth, self._camera)
        self._on_frame(message.header, SensorFrame(points, self._camera.fx))
