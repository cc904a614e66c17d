"""Publishes a bag's messages, unchanged, with ``/clock``."""

import importlib
from collections.abc import Iterable, Sequence
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import QosDurability
from rosgraph_msgs.msg import Clock

from shirube_bags.bag_reader import BagMessage, BagTopic
from shirube_bags.errors import ReplayError
from shirube_bags.stamps import NANOSECONDS


def load_message_class(msgtype: str) -> Any:
    """Return the class of a message such as ``sensor_msgs/msg/Image`` or of a service's events, such as
    ``std_srvs/srv/Trigger_Event``; raise a ReplayError if it is not installed or not to be published.
    """
    package, kind, name = (*msgtype.split('/'), '', '')[:3]
    if kind not in {'msg', 'srv'} or (kind == 'srv' and not name.endswith('_Event')):
        raise ReplayError(f'{msgtype} is neither a message nor the events of a service; it can only be read')
    try:
        module = importlib.import_module(f'{package}.{kind}')
        return getattr(module, name) if kind == 'msg' else getattr(module, name.removesuffix('_Event')).Event
    except (ImportError, AttributeError, TypeError, ValueError) as fault:
        raise ReplayError(f'the message type {msgtype} is not installed; install its package {package}') from fault


LARGEST_LATCHED_HISTORY = 1000
CLOCK = '/clock'


class BagPlayer:
    """Publishes the messages of a bag from one node.

    Messages are published as their recorded bytes. ``/clock`` is the time of recording, unless the bag contains
    ``/clock`` itself: then that is replayed.
    """

    def __init__(self, node: Node, topics: Iterable[BagTopic]) -> None:
        """Create the publishers of the topics; raise a ReplayError if a type is not installed."""
        self._publishers: dict[str, Publisher] = {
            topic.name: node.create_publisher(load_message_class(topic.msgtype), topic.name, replay_qos(topic))
            for topic in topics
        }
        self._clock = None if CLOCK in self._publishers else node.create_publisher(Clock, CLOCK, 10)
        self._clock_ns = -1

    @property
    def topics(self) -> tuple[str, ...]:
        """Published topics."""
        return tuple(self._publishers)

    def resolve_topic(self, topic: str) -> str:
        """Return the name of a topic after remapping."""
        return str(self._publisher(topic).topic_name)

    def subscriber_count(self, topic: str) -> int:
        """Return the number of subscribers of a topic."""
        return int(self._publisher(topic).get_subscription_count())

    def publish(self, message: BagMessage) -> None:
        """Set the clock to the message's stamp and publish it."""
        self.set_clock(message.stamp_ns)
        self._publishers[message.topic].publish(message.raw)

    def set_clock(self, stamp_ns: int) -> None:
        """Publish a time [ns] on ``/clock``, if it is later than the last one."""
        if self._clock is None or stamp_ns <= self._clock_ns:
            return
        self._clock_ns = stamp_ns
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(stamp_ns, NANOSECONDS)
        self._clock.publish(message)

    def rewind(self) -> None:
        """Let the clock jump back, for the next iteration of a loop."""
        self._clock_ns = -1

    def wait_until_received(self, topics: Sequence[str], timeout: float) -> None:
        """Wait, up to a timeout [s] each, until the reliable subscribers of the topics have acknowledged all
        messages.
        """
        for topic in topics:
            self._publishers[topic].wait_for_all_acked(Duration(seconds=timeout))

    def _publisher(self, topic: str) -> Publisher:
        return self._clock if topic == CLOCK and self._clock is not None else self._publishers[topic]


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
