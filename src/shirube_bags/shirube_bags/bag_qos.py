"""QoS profiles that a bag stores with each topic, for the player."""

from __future__ import annotations

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

# Infinite duration, as ROS 2 writes it.
INFINITE = QosTime(9223372036, 854775807)

LATCHED_TYPES = frozenset({'nav_msgs/msg/OccupancyGrid'})
LATCHED_TOPICS = frozenset({'/tf_static', '/robot_description'})


def reliable_qos(depth: int = 10, latched: bool = False) -> Qos:
    """Return a reliable profile that keeps the last ``depth`` messages.

    Reliable is compatible with reliable and best-effort subscribers.

    Args:
        depth: number of messages kept for a subscriber that has not acknowledged them.
        latched: whether late subscribers receive the last messages (transient local).
    """
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=depth,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
        deadline=INFINITE,
        lifespan=INFINITE,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=INFINITE,
        avoid_ros_namespace_conventions=False,
    )


def default_qos(topic: str, msgtype: str) -> Qos:
    """Return the default profile for a topic name and type.

    Maps and static transforms, which are published once, are latched (transient local).
    """
    latched = topic in LATCHED_TOPICS or msgtype in LATCHED_TYPES
    return reliable_qos(depth=1 if latched else 10, latched=latched)
