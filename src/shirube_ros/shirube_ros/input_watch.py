"""Reports inputs that are missing, have another type or incompatible QoS, or have died: once on the console."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from time import monotonic

from rclpy.node import Node
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.subscription import Subscription

from shirube_ros.callback_guard import TopicCount

_START_TIME = 2.5  # time for discovery and first messages [s]
_TIMEOUT = 2.0  # an input without a message for this long has died [s]
_REPEAT_TIME = 60.0  # the same line is logged again after this at the earliest [s]


class Need(Enum):
    """How a node depends on an input.

    A required input that is missing is a warning of the diagnostics; one that is expected is logged only. An optional
    one is reported if it dies. A command needs a publisher, which may rest; a request, such as a goal, comes at any
    time. All are reported if their type is wrong.
    """

    REQUIRED = 'required'
    EXPECTED = 'expected'
    OPTIONAL = 'optional'
    COMMAND = 'command'
    REQUEST = 'request'


@dataclass
class _Input:
    """One input: its topics (such as raw and compressed images), and what is known of it."""

    name: str
    topics: tuple[str, ...]
    need: Need
    keys: tuple[str, ...]
    remedy: str
    accepted: int = 0
    received: int = 0
    latest: float = 0.0
    problem: str = ''
    is_wrong: bool = False
    logged: dict[str, float] = field(default_factory=dict)


class InputWatch:
    """Compares the numbers of received messages from check to check, and asks the graph why there are no new ones.

    Attributes:
        is_active: whether inputs are checked.
    """

    def __init__(self, node: Node, counts: Mapping[str, TopicCount]) -> None:
        """Start without inputs; the counts of received messages are those of the node's guard."""
        self._node, self._counts = node, counts
        self._inputs: list[_Input] = []
        self.is_active = False

    def add(self, topic: str, need: Need, *, name: str = '', remedy: str = '') -> None:
        """Watch a topic; its count has the ``name``, by default the topic. The remedy is one for a wrong type."""
        resolved = self._node.resolve_topic_name(topic)
        label = f'{resolved} ({name})' if name else resolved
        self._inputs.append(_Input(label, (resolved,), need, (name or topic,), remedy))

    def add_images(self, topic: str, info_topic: str) -> None:
        """Watch images, raw or compressed, and their CameraInfo, which are required."""
        resolved = self._node.resolve_topic_name(topic)
        topics = resolved, f'{resolved}/compressed'
        self._inputs.append(_Input(resolved, topics, Need.REQUIRED, (topic, topics[1]), ''))
        self.add(info_topic, Need.REQUIRED)

    def start(self) -> None:
        """Start anew, as the node was activated."""
        self.is_active = True
        for each in self._inputs:
            self._count(each, monotonic())

    def clear(self) -> None:
        """Forget all inputs."""
        self._inputs.clear()
        self.is_active = False

    @property
    def problems(self) -> dict[str, str]:
        """The problem of each input that has one."""
        return {each.name: each.problem for each in self._inputs if each.problem}

    @property
    def missing(self) -> list[str]:
        """The problems of required inputs."""
        return [each.problem for each in self._inputs if each.problem and each.need is Need.REQUIRED]

    @property
    def mismatches(self) -> list[str]:
        """The problems of other inputs that have the wrong type or QoS."""
        return [each.problem for each in self._inputs if each.is_wrong and each.need is not Need.REQUIRED]

    def check(self) -> None:
        """Look for new messages and log new problems; call it once a second."""
        for each in self._inputs if self.is_active else ():
            accepted, had_problem, now = each.accepted, each.problem, monotonic()
            if self._accepted(each) != accepted:
                self._count(each, now)
                if had_problem:
                    self._node.get_logger().info(f'{each.name} is received')
            elif now - each.latest > (_TIMEOUT if accepted else _START_TIME):
                each.problem, each.is_wrong = self._diagnose(each)
                if each.problem and now - each.logged.get(each.problem, -_REPEAT_TIME) >= _REPEAT_TIME:
                    each.logged[each.problem] = now
                    self._node.get_logger().warning(each.problem)

    def _count(self, each: _Input, now: float) -> None:
        each.accepted, each.received, each.latest = self._accepted(each), self._received(each), now
        each.problem, each.is_wrong = '', False

    def _received(self, each: _Input) -> int:
        return sum(self._counts[key].received for key in each.keys if key in self._counts)

    def _accepted(self, each: _Input) -> int:
        counts = [self._counts[key] for key in each.keys if key in self._counts]
        return sum(count.received - count.rejected.total() for count in counts)

    def _diagnose(self, each: _Input) -> tuple[str, bool]:
        """Return why no message arrives, and whether a publisher is wrong; empty if nothing must arrive."""
        publishers = 0
        # The first one of a topic counts; a further one, which fetches stored messages, does not match all publishers.
        for subscription in {s.topic_name: s for s in reversed([*self._node.subscriptions])}.values():
            if subscription.topic_name in each.topics:
                for wrong in _mismatches(self._node, subscription):
                    if wrong:
                        return f'{wrong}; {each.remedy}' if each.remedy and ' as ' in wrong else wrong, True
                    publishers += 1
        is_optional = each.need is Need.OPTIONAL and not each.accepted
        if each.need is Need.REQUEST or is_optional:
            return '', False
        if self._received(each) != each.received:
            each.received = self._received(each)
            return f'{each.name}: all messages are rejected', False
        if not publishers:
            return f'{each.name} has no publisher; check the topic name', False
        if each.need is Need.COMMAND:
            return '', False
        silence = f'no message for {_TIMEOUT:g} s' if each.accepted else 'published, but no message arrives'
        return f'{each.name}: {silence}; check its publisher', False


def _mismatches(node: Node, subscription: Subscription) -> Iterator[str]:
    """Return why the subscription receives nothing from a publisher, or an empty text, for each publisher."""
    topic, kind = subscription.topic_name, subscription.msg_type
    expected = f'{kind.__module__.split(".")[0]}/msg/{kind.__name__}'
    for publisher in node.get_publishers_info_by_topic(topic):
        if publisher.topic_type != expected:
            yield f'{topic} is published as {publisher.topic_type}, not as {expected}'
            continue
        compatibility, reason = qos_check_compatible(publisher.qos_profile, subscription.qos_profile)
        if compatibility == QoSCompatibility.ERROR:
            why = ' '.join(reason.replace('ERROR: ', '').rstrip(';').split())
            yield (
                f'{topic} is published by {publisher.node_name} with incompatible QoS ({why}); '
                f'change it there, or here by qos_overrides.{topic}.subscription.reliability'
            )
        else:
            yield ''
