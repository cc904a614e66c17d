"""Output of the arbiter at a fixed rate: the fused pose, and map to odom on /tf."""

from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Header

from pose_arbiter.core.kalman_filter import Estimate, as_matrix
from pose_arbiter.node_settings import NodeSettings
from shirube_core.geometry import SE2
from shirube_ros.pose_conversion import odometry_message, pose_message, pose_stamped, pose_with_covariance_stamped
from shirube_ros.quality_of_service import pose_profile
from shirube_ros.transform_publisher import TransformPublisher

_BACKLOG_MAX = 500_000_000  # older ticks are dropped [ns]


class TickSchedule:
    """Ticks at multiples of the period, none skipped under load; integers, so that they do not drift."""

    def __init__(self, rate: float) -> None:
        """Start at the first call of `due`, with a tick rate [1/s]."""
        self._period = round(1e9 / rate)
        self._last_done: int | None = None

    def reset(self) -> None:
        """Drop the due ticks after a clock jump."""
        self._last_done = None

    def due(self, now: int) -> range:
        """Return the stamps of the ticks since the last call, up to now [ns]."""
        last = now // self._period
        if self._last_done is None:
            self._last_done = last - 1
        first = max(self._last_done + 1, (now - _BACKLOG_MAX) // self._period + 1)
        self._last_done = max(self._last_done, last)
        return range(first * self._period, last * self._period + 1, self._period)


# Least standard deviations of an area for another localizer [m], [rad].
_AREA_SIGMA, _AREA_SIGMA_YAW = 0.05, 0.05


class ArbiterOutput:
    """Publishers of the fused pose and of the transform."""

    def __init__(self, node: Node, settings: NodeSettings) -> None:
        """Create the publishers.

        Args:
            node: node that publishes.
            settings: frames, and whether to publish the transform.
        """
        self._settings = settings
        self._pose = node.create_publisher(PoseStamped, '~/pose', pose_profile())
        self._odometry = node.create_publisher(Odometry, '~/odometry', pose_profile())
        self._transforms = TransformPublisher(node) if settings.publish_tf else None
        if settings.initialpose_for:
            self._area = node.create_publisher(PoseWithCovarianceStamped, '~/initialpose', pose_profile())

    def publish_pose(self, stamp: int, estimate: Estimate, twist: Any) -> None:
        """Publish the pose at a stamp [ns], with the twist of the latest odometry message or None."""
        header = Header(stamp=_time(stamp), frame_id=self._settings.map_frame)
        self._pose.publish(pose_stamped(estimate.pose, header))
        covariance = as_matrix(estimate.covariance)
        message = odometry_message(estimate.pose, covariance, header, self._settings.base_frame)
        if twist is not None:
            message.twist = twist
        self._odometry.publish(message)

    def publish_area(self, stamp: int, estimate: Estimate) -> None:
        """Publish the pose at a stamp [ns] as the area where a silent localizer searches first."""
        covariance = np.array(as_matrix(estimate.covariance))
        least = np.array([_AREA_SIGMA, _AREA_SIGMA, _AREA_SIGMA_YAW]) ** 2
        np.fill_diagonal(covariance, np.maximum(covariance.diagonal(), least))
        header = Header(stamp=_time(stamp), frame_id=self._settings.map_frame)
        self._area.publish(pose_with_covariance_stamped(estimate.pose, covariance, header))

    def publish_transform(self, stamp: int, T_map_odom: SE2) -> None:
        """Publish the pose of the odometry frame in the map, stamped ``transform_tolerance`` ahead of a stamp [ns]."""
        if self._transforms is not None:
            ahead = _time(stamp + round(1e9 * self._settings.transform_tolerance))
            parent, child = self._settings.map_frame, self._settings.odom_frame
            self._transforms.publish(ahead, parent, child, pose_message(T_map_odom))


def _time(stamp: int) -> Time:
    """Return a stamp [ns] as a message, without loss."""
    sec, nanosec = divmod(stamp, 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)
