"""The executor of a node, and a queue that is drained."""

from collections.abc import Iterator
from contextlib import ExitStack
from time import monotonic

import pytest
import rclpy
from domain_coordinator import domain_id
from node_testing import IsolatedGraph
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Int32, String

from shirube_ros import node
from shirube_ros.node import drain_subscription

Graph = tuple[rclpy.Context, Executor]


@pytest.fixture(params=['events', 'wait sets'])
def executing(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Graph]:
    """Return a context and the executor: that of this rclpy, and the one for an rclpy without it."""
    if request.param == 'wait sets':
        monkeypatch.setattr(node, 'EventsExecutor', None)
    with ExitStack() as stack:
        context = rclpy.Context()
        rclpy.init(context=context, domain_id=stack.enter_context(domain_id()))
        stack.callback(context.try_shutdown)
        executor = node.node_executor(context)
        assert isinstance(executor, SingleThreadedExecutor) == (request.param == 'wait sets')
        stack.callback(executor.shutdown)
        yield context, executor


def test_messages_and_timers_of_simulated_time_are_worked_off(executing: Graph) -> None:
    context, executor = executing
    node = Node('hearer', context=context, parameter_overrides=[Parameter('use_sim_time', value=True)])
    received: list[object] = []
    node.create_subscription(Int32, 'number', lambda message: received.append(message.data), 10)
    ticks: list[int] = []
    node.create_timer(0.1, lambda: ticks.append(node.get_clock().now().nanoseconds))
    publisher_node = Node('speaker', context=context)
    numbers = publisher_node.create_publisher(Int32, 'number', 10)
    clock = publisher_node.create_publisher(Clock, '/clock', 10)
    executor.add_node(node)
    executor.add_node(publisher_node)
    while numbers.get_subscription_count() == 0 or clock.get_subscription_count() < 1:
        executor.spin_once(timeout_sec=0.05)
    for k in range(40):
        clock.publish(Clock(clock=rclpy.time.Time(nanoseconds=50_000_000 * (k + 1)).to_msg()))
        numbers.publish(Int32(data=k))
        end = monotonic() + 10.0
        while len(received) <= k and monotonic() < end:
            executor.spin_once(timeout_sec=0.05)
    assert received == list(range(40))
    assert 17 <= len(ticks) <= 20
    node.destroy_node()
    publisher_node.destroy_node()


def test_a_fault_in_a_callback_comes_out(executing: Graph) -> None:
    context, executor = executing
    node = Node('faulty', context=context)

    def fail() -> None:
        raise ZeroDivisionError('a mistake')

    node.create_timer(0.01, fail)
    node.create_subscription(String, 'words', lambda message: None, 10)
    executor.add_node(node)
    with pytest.raises(ZeroDivisionError):  # noqa: PT012 it comes out of one of them
        for _ in range(100):
            executor.spin_once(timeout_sec=0.1)
    node.destroy_node()


def test_all_that_waits_is_taken_in_its_order(graph: IsolatedGraph) -> None:
    publisher_node = graph.node('publisher')
    listener = graph.node('listener')
    publisher = publisher_node.create_publisher(Int32, 'number', 100)
    received: list[int] = []
    counts: list[int] = []

    def take(message: Int32) -> None:
        received.append(message.data)
        if message.data == 0:
            for number in range(1, 50):
                publisher.publish(Int32(data=number))
            while len(received) < 50:
                drain_subscription(subscription)
            counts.append(len(received))

    subscription = listener.create_subscription(Int32, 'number', take, 100)
    assert graph.spin_until(lambda: publisher.get_subscription_count() == 1)
    publisher.publish(Int32(data=0))
    assert graph.spin_until(lambda: bool(counts), 10.0)
    assert received == list(range(50))
