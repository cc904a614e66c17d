"""Missing, wrong and dead inputs."""

from types import SimpleNamespace

import pytest
from node_testing import IsolatedGraph
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64

from shirube_ros import input_watch
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.errors import MessageError
from shirube_ros.input_watch import InputWatch, Need
from shirube_ros.quality_of_service import pose_profile


class Watched:
    """A node with a subscription that is watched, and a node that publishes."""

    def __init__(self, graph: IsolatedGraph, need: Need) -> None:
        self._graph = graph
        self.node = graph.node('watched')
        self._guard = CallbackGuard(self.node)
        self.watch = InputWatch(self.node, self._guard.counts)
        self.watch.add('number', need, remedy='change stamped')
        self.node.create_subscription(Float64, 'number', self._guard.guard('number', self._take), pose_profile())
        self.watch.start()
        self._publisher_node = graph.node('publisher')

    def _take(self, message: Float64) -> None:
        if message.data < 0.0:
            raise MessageError('negative')

    def publish(self, *numbers: float) -> None:
        publisher = self._publisher_node.create_publisher(Float64, 'number', 10)
        assert self._graph.spin_until(lambda: publisher.get_subscription_count() == 1)
        received = self._guard.counts['number'].received + len(numbers)
        for number in numbers:
            publisher.publish(Float64(data=number))
        assert self._graph.spin_until(lambda: self._guard.counts['number'].received == received)

    def problem(self) -> str:
        self.watch.check()
        return self.watch.problems.get('/number', '')


@pytest.fixture(autouse=True)
def _without_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(input_watch, '_START_TIME', -1.0)
    monkeypatch.setattr(input_watch, '_TIMEOUT', -1.0)


MISSING = '/number has no publisher; check the topic name'
DEAD = '/number: no message for -1 s; check its publisher'
SILENT = '/number: published, but no message arrives; check its publisher'


@pytest.mark.parametrize(
    ('need', 'before', 'silent', 'dead'),
    [
        (Need.REQUIRED, MISSING, SILENT, DEAD),
        (Need.EXPECTED, MISSING, SILENT, DEAD),
        (Need.OPTIONAL, '', '', DEAD),
        (Need.COMMAND, MISSING, '', ''),
        (Need.REQUEST, '', '', ''),
    ],
)
def test_what_lacks_is_reported_once_by_need(
    graph: IsolatedGraph, capfd: pytest.CaptureFixture[str], need: Need, before: str, silent: str, dead: str
) -> None:
    watched = Watched(graph, need)
    assert [watched.problem() for _ in range(3)] == [before] * 3
    watched.publish()
    assert watched.problem() == silent
    watched.publish(1.0)
    assert watched.problem() == ''
    assert [watched.problem() for _ in range(3)] == [dead] * 3
    assert watched.watch.missing == ([DEAD] if need is Need.REQUIRED else [])
    watched.publish(-1.0)
    assert watched.problem() == ('' if need is Need.REQUEST else '/number: all messages are rejected')
    words = capfd.readouterr().err
    for line in filter(None, (before, silent, dead)):
        assert words.count(line) == 1


def test_another_type_is_reported_with_its_remedy(graph: IsolatedGraph, monkeypatch: pytest.MonkeyPatch) -> None:
    watched = Watched(graph, Need.REQUEST)
    offer = SimpleNamespace(topic_type='std_msgs/msg/String')  # both types cannot share this process
    monkeypatch.setattr(watched.node, 'get_publishers_info_by_topic', lambda _: [offer])
    words = '/number is published as std_msgs/msg/String, not as std_msgs/msg/Float64; change stamped'
    assert watched.problem() == words
    assert watched.watch.mismatches == [words]


def test_incompatible_qos_is_reported(graph: IsolatedGraph) -> None:
    watched = Watched(graph, Need.OPTIONAL)
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    best_effort.durability = DurabilityPolicy.VOLATILE
    publisher = watched._publisher_node.create_publisher(Float64, 'number', best_effort)
    assert graph.spin_until(lambda: watched.node.count_publishers('number') == 1)
    assert publisher.get_subscription_count() == 0
    assert '/number is published by publisher with incompatible QoS (' in watched.problem()
    assert 'qos_overrides./number.subscription.reliability' in watched.problem()
