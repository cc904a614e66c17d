"""Subscription to point clouds."""

from __future__ import annotations

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2

from reward_planner.core.navigator import SensorFrame
from reward_planner.core.voxels.point_density import equivalent_focal_length
from reward_planner.inputs.frame_callback import FrameCallback
from shirube_core.geometry import CameraMount
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.errors import PointCloudError
from shirube_ros.map_conversion import points_from_cloud
from shirube_ros.quality_of_service import overridable, sensor_profile

_TOPIC = 'points'
_OPTICAL = '_optical_frame'


class PointsInput:
    """Subscribes to ``points`` (PointCloud2) in the camera's optical frame or in ``base_frame``."""

    def __init__(
        self,
        node: Node,
        guard: CallbackGuard,
        mount: CameraMount,
        frames: tuple[str, str],
        on_frame: FrameCallback,
    ) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
            guard: counts the messages and catches their errors.
            mount: pose of the camera, the origin of rays also for points in the base frame.
            frames: name of the robot's frame, and of the camera's optical frame; empty takes the first one received.
            on_frame: called for each valid cloud.
        """
        self._mount, self._on_frame = mount, on_frame
        self._base_frame, self._camera_frame = frames
        node.create_subscription(
            PointCloud2,
            _TOPIC,
            guard.guard(_TOPIC, self._take),
            sensor_profile(),
            qos_overriding_options=overridable(),
        )

    def _take(self, message: PointCloud2) -> None:
        frame = message.header.frame_id
        self._check_frame(frame)
        points = points_from_cloud(message, _TOPIC)
        if frame != self._base_frame:
            self._camera_frame = frame  # the mount belongs to one camera
        else:
            shifted = points - np.asarray(self._mount.xyz, dtype=np.float32)
            points = shifted @ self._mount.rotation.astype(np.float32)
        self._on_frame(message.header, SensorFrame(points, equivalent_focal_length(points)))

    def _check_frame(self, frame: str) -> None:
        """Reject clouds of other cameras than the one of the mount."""
        if frame and frame in (self._base_frame, self._camera_frame):
            return
        if self._camera_frame:
            raise PointCloudError(
                f'{_TOPIC} is in the frame {frame!r}, the camera with this mount is {self._camera_frame!r}; '
                f'publish one camera only, or transform the others to {self._base_frame!r}'
            )
        if not frame.endswith(_OPTICAL):
            raise PointCloudError(
                f'{_TOPIC} is in the unknown frame {frame!r}; '
                f'publish it in {self._base_frame!r} or in the camera\'s frame, whose name ends with "{_OPTICAL}"'
            )
