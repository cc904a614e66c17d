"""Records live topics into a bag."""

from collections.abc import Callable, Sequence
from functools import partial

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rosbags.interfaces import Qos, QosDurability, QosReliability

from shirube_bags.bag_player import load_message_class
from shirube_bags.bag_reader import jazzy_types
from shirube_bags.bag_writer import BagWriter, reliable_qos
from shirube_bags.errors import ReplayError


class BagRecorder:
    """Subscribes to topics when they appear and writes their serialized messages into a bag."""

    def __init__(self, node: Node, bag: BagWriter, topics: Sequence[str], log: Callable[[str], None]) -> None:
        """Start without subscriptions; record ``topics``, all if empty, stamped by the node's clock, and log
        each one.
        """
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
        """Subscribe to new topics, periodically; raise a ReplayError if the type of a requested one cannot
        be recorded.
        """
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
    """Return the class of a live topic; raise a ReplayError for several types, or one that cannot be
    recorded.
    """
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
