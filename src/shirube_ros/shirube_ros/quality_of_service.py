"""Quality of service by kind of data.

Each function makes a new profile, because rclpy writes a user's overrides into the profile that it is given.
"""

from __future__ import annotations

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

_SENSOR_DEPTH = 5  # that of rmw's sensor data profile
_ODOMETRY_DEPTH = 100
_POSE_DEPTH = 10


def sensor_profile() -> QoSProfile:
    """Images and CameraInfo: a late image is worth nothing, a slow network must not block the camera."""
    return _keep_last(_SENSOR_DEPTH, ReliabilityPolicy.BEST_EFFORT)


def odometry_profile() -> QoSProfile:
    """Odometry: comes many times an image and waits while an image is worked on; hears every publisher."""
    return _keep_last(_ODOMETRY_DEPTH, ReliabilityPolicy.BEST_EFFORT)


def pose_profile() -> QoSProfile:
    """Poses, requests of people and whatever else must arrive."""
    return _keep_last(_POSE_DEPTH, ReliabilityPolicy.RELIABLE)


def map_profile() -> QoSProfile:
    """Maps: who comes later gets the latest one."""
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


def overridable() -> QoSOverridingOptions:
    """Let the user set history, depth and reliability of a topic by parameter.

    For example ``-p qos_overrides./image_raw.subscription.reliability:=reliable``.
    """
    return QoSOverridingOptions.with_default_policies()


def _keep_last(depth: int, reliability: ReliabilityPolicy) -> QoSProfile:
    return QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=reliability)
