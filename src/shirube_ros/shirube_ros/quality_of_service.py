"""QoS profiles by kind of data.

Each function returns a new profile, because rclpy writes a user's overrides into the profile that it is given.
"""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions


def sensor_profile() -> QoSProfile:
    """Images and CameraInfo: best effort, so that a slow network does not block the camera."""
    return _keep_last(5, ReliabilityPolicy.BEST_EFFORT)  # as in rmw's sensor data profile


def odometry_profile() -> QoSProfile:
    """Odometry: a deep queue for messages that arrive during image processing; best effort matches any publisher."""
    return _keep_last(100, ReliabilityPolicy.BEST_EFFORT)


def pose_profile() -> QoSProfile:
    """Poses, goals and other messages that must arrive: reliable."""
    return _keep_last(10, ReliabilityPolicy.RELIABLE)


def map_profile() -> QoSProfile:
    """Maps: transient local, so that late subscribers receive the latest one."""
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
