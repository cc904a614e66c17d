"""The quality of service that a bag stores with each topic, so that a player offers it again."""

from __future__ import annotations

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

# What ROS 2 writes for a duration without a limit.
INFINITE = QosTime(9223372036, 854775807)

LATCHED_TYPES = frozenset({'nav_msgs/msg/OccupancyGrid'})
LATCHED_TOPICS = frozenset({'/tf_static', '/robot_description'})


def reliable_qos(depth: int = 10, latched: bool = False) -> Qos:
    """Return a reliable profile that keeps the last ``depth`` messages.

    Reliable is offered because it serves both kinds of subscriber, reliable and best effort.

    Args:
        depth: messages kept for a subscriber that has not acknowledged them.
        latched: True if a late subscriber gets the last messages too (transient local).
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
    """Return the profile for a topic of which nothing is known but its name and type.

    Maps and static transforms, which are published once, are latched.
    """
    latched = topic in LATCHED_TOPICS or msgtype in LATCHED_TYPES
    return reliable_qos(depth=1 if latched else 10, latched=latched)
