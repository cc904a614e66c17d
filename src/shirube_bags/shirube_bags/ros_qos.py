"""Conversion of QoS profiles between bags and rclpy."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosbags.interfaces import Qos, QosDurability, QosReliability

from shirube_bags.bag_qos import reliable_qos
from shirube_bags.bag_reader import BagTopic

LARGEST_LATCHED_HISTORY = 1000


def replay_qos(topic: BagTopic) -> QoSProfile:
    """Return the profile for the replay of a topic.

    It is always reliable, which is compatible with every subscriber, and keeps all messages until reliable subscribers
    have acknowledged them. Latched (transient local) topics stay latched.
    """
    if any(each.durability is QosDurability.TRANSIENT_LOCAL for each in topic.qos):
        max_depth = max(each.depth for each in topic.qos)
        return QoSProfile(
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
            history=HistoryPolicy.KEEP_LAST,
            depth=max(1, max_depth, min(topic.message_count, LARGEST_LATCHED_HISTORY)),
        )
    return QoSProfile(reliability=ReliabilityPolicy.RELIABLE, history=HistoryPolicy.KEEP_ALL)


def recording_qos(publishers: Sequence[TopicEndpointInfo]) -> QoSProfile:
    """Return the strictest profile compatible with all publishers of a topic, with an unlimited queue."""
    qos = offered_qos(publishers)
    reliable = qos.reliability is QosReliability.RELIABLE
    latched = qos.durability is QosDurability.TRANSIENT_LOCAL
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_ALL,
    )


def offered_qos(publishers: Sequence[TopicEndpointInfo]) -> Qos:
    """Return the profile that all publishers of a topic offer, as stored in a bag."""
    profiles = [each.qos_profile for each in publishers]
    latched = all(each.durability == DurabilityPolicy.TRANSIENT_LOCAL for each in profiles)
    # Discovery does not transmit the depth: it is 0.
    depth = max([each.depth for each in profiles if each.depth > 0], default=1 if latched else 10)
    qos = reliable_qos(depth, latched)
    if all(each.reliability == ReliabilityPolicy.RELIABLE for each in profiles):
        return qos
    return qos._replace(reliability=QosReliability.BEST_EFFORT)
