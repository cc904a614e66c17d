"""Quality of service between bags and rclpy."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosbags.interfaces import Qos, QosDurability, QosReliability

from shirube_bags.bag_qos import reliable_qos
from shirube_bags.bag_reader import BagTopic

LARGEST_LATCHED_HISTORY = 1000


def replay_qos(topic: BagTopic) -> QoSProfile:
    """Return the profile a topic is replayed with.

    It is reliable whatever the bag offered, since that serves every subscriber, and nothing is discarded
    before all reliable subscribers have it. Latched topics stay latched.
    """
    if any(each.durability is QosDurability.TRANSIENT_LOCAL for each in topic.qos):
        deepest = max(each.depth for each in topic.qos)
        return QoSProfile(
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            history=HistoryPolicy.KEEP_LAST,
            depth=max(1, deepest, min(topic.message_count, LARGEST_LATCHED_HISTORY)),
        )
    return QoSProfile(reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_ALL)


def recording_qos(publishers: Sequence[TopicEndpointInfo]) -> QoSProfile:
    """Return the strongest profile that all the publishers of a topic can serve, with a queue without end."""
    qos = offered_qos(publishers)
    reliable = qos.reliability is QosReliability.RELIABLE
    latched = qos.durability is QosDurability.TRANSIENT_LOCAL
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_ALL,
    )


def offered_qos(publishers: Sequence[TopicEndpointInfo]) -> Qos:
    """Return what all the publishers of a topic offer, as a bag stores it."""
    profiles = [each.qos_profile for each in publishers]
    latched = all(each.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in profiles)
    # The discovery does not tell the depth: 0 there.
    depth = max([each.depth for each in profiles if each.depth > 0], default=1 if latched else 10)
    qos = reliable_qos(depth, latched)
    if all(each.reliability == ReliabilityPolicy.RELIABLE for each in profiles):
        return qos
    return qos._replace(reliability=QosReliability.BEST_EFFORT)
