"""A node, its executor and a stop event for a command, with clean shutdown; the player and the recorder of bags."""

import importlib
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosbags.interfaces import Qos, QosDurability, QosReliability
from rosgraph_msgs.msg import Clock

from shirube_bags.bag_reader import BagMessage, BagTopic, jazzy_types
from shirube_bags.bag_writer import BagWriter, reliable_qos
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
        """Wait, up to a timeout [s] each, until reliable subscribers of the topics have acknowledged all messages."""
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


class BagRecorder:
    """Subscribes to topics when they appear and writes their serialized messages into a bag."""

    def __init__(self, node: Node, bag: BagWriter, topics: Sequence[str], log: Callable[[str], None]) -> None:
        """Start without subscriptions; record ``topics``, all if empty, stamped by the node's clock; log each one."""
        self._node = node
        self._bag = bag
        self._wanted = [node.resolve_topic_name(topic) for topic in topics]
        self._log = log
        self._subscriptions: dict[str, Subscription] = {}
        self._skipped: set[str] = set()
        self._unstamped: list[tuple[str, str, bytes]] = []
        self.counts: dict[str, int] = {}

    @property
    def missing_topics(self) -> list[str]:
        """Requested topics without a publisher so far."""
        return [topic for topic in self._wanted if topic not in self._subscriptions]

    def find_topics(self) -> None:
        """Subscribe to new topics; raise a ReplayError if the type of a requested one cannot be recorded."""
        for topic, types in self._node.get_topic_names_and_types():
            if topic in self._subscriptions or topic in self._skipped:
                continue
            if self._wanted and topic not in self._wanted:
                continue
            publishers = [
                each
                for each in self._node.get_publishers_info_by_topic(topic)
                if each.node_name != self._node.get_name()
            ]
            if publishers:
                self._add(topic, types, publishers)

    def _add(self, topic: str, types: Sequence[str], publishers: Sequence[TopicEndpointInfo]) -> None:
        try:
            message_class = get_message_class(topic, types)
        except ReplayError as fault:
            if self._wanted:
                raise
            self._skipped.add(topic)
            self._log(f'{topic} is skipped: {fault}')
            return
        msgtype = types[0]
        self._bag.declare(topic, msgtype, offered_qos(publishers))
        self.counts[topic] = 0
        self._subscriptions[topic] = self._node.create_subscription(
            message_class, topic, partial(self._write, topic, msgtype), recording_qos(publishers), raw=True
        )
        self._log(f'recording {topic} [{msgtype}]')

    def _write(self, topic: str, msgtype: str, raw: bytes) -> None:
        self._unstamped.append((topic, msgtype, raw))
        stamp_ns = self._node.get_clock().now().nanoseconds
        # Simulated time is 0 before the first /clock: a stamp of 0 would make the bag decades long.
        if stamp_ns == 0:
            return
        for message in self._unstamped:
            self._bag.write_raw(*message, stamp_ns)
            self.counts[message[0]] += 1
        self._unstamped.clear()


def get_message_class(topic: str, types: Sequence[str]) -> object:
    """Return the class of a live topic; raise a ReplayError for several types, or one that cannot be recorded."""
    if len(types) != 1:
        raise ReplayError(f'{topic} is published with the types {", ".join(types)}; publish one type per topic')
    if types[0] not in jazzy_types().fielddefs:
        raise ReplayError(
            f"{topic} has the type {types[0]}, which is not in ROS 2's common interfaces; use ros2 bag record"
        )
    message_class: object = load_message_class(types[0])
    return message_class


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


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Provide an event that SIGINT and SIGTERM set; restore the previous handlers at the end."""
    stop = threading.Event()
    signals = (signal.SIGINT, signal.SIGTERM)
    former = {each: signal.signal(each, lambda _number, _frame: stop.set()) for each in signals}
    try:
        yield stop
    finally:
        for each, handler in former.items():
            signal.signal(each, handler)


@dataclass(frozen=True)
class RosSession:
    """A node and the executor that spins it."""

    node: Node
    executor: SingleThreadedExecutor


@contextmanager
def ros_session(
    name: str, arguments: Sequence[str], use_sim_time: bool = False, domain: int | None = None
) -> Iterator[RosSession]:
    """Create a node from a command line with ``--ros-args``; the caller handles signals (`stop_on_signals`)."""
    context = Context()
    rclpy.init(args=list(arguments), context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    try:
        override = [rclpy.Parameter('use_sim_time', value=True)] if use_sim_time else []
        node = Node(name, context=context, parameter_overrides=override)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        try:
            yield RosSession(node, executor)
        finally:
            executor.shutdown()
            node.destroy_node()
    finally:
        context.try_shutdown()
