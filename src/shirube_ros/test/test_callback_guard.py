"""The guard of callbacks and services."""

from __future__ import annotations

from typing import Any

import pytest
from node_testing import IsolatedGraph
from rclpy.node import Node
from std_srvs.srv import Trigger

from shirube_ros.callback_guard import CallbackGuard, TopicCount, create_trigger_service
from shirube_ros.errors import MessageError


def reject(message: str) -> None:
    raise MessageError(message)


def fail(_: Any) -> None:
    raise ZeroDivisionError


def make_guard(graph: IsolatedGraph) -> CallbackGuard:
    return CallbackGuard(graph.add(lambda **options: Node('guarded', **options)))


def test_good_messages_go_through(graph: IsolatedGraph) -> None:
    guard, seen = make_guard(graph), []
    take = guard.guard('image', seen.append)
    take('a')
    take('b')
    assert seen == ['a', 'b']
    assert (guard.counts['image'].received, guard.counts['image'].rejected.total()) == (2, 0)


def test_refused_messages_are_counted_by_reason(graph: IsolatedGraph) -> None:
    guard = make_guard(graph)
    take = guard.guard('image', reject)
    for reason in ('too dark', 'too dark', 'too small'):
        take(reason)
    assert guard.counts['image'].rejected == {'too dark': 2, 'too small': 1}
    assert guard.counts['image'].latest_rejection == 'too small'


def test_a_fault_of_the_program_does_not_end_the_node(graph: IsolatedGraph) -> None:
    guard = make_guard(graph)
    guard.guard('odom', fail)(None)
    assert guard.counts['odom'].rejected == {'ZeroDivisionError in odom': 1}


def test_the_package_may_name_errors_of_its_own(graph: IsolatedGraph) -> None:
    node = graph.add(lambda **options: Node('guarded', **options))
    guard = CallbackGuard(node, (ZeroDivisionError,))
    guard.guard('odom', lambda _: 1 // 0)(None)
    assert guard.counts['odom'].rejected == {'integer division or modulo by zero': 1}


def test_the_number_of_reasons_is_bounded() -> None:
    count = TopicCount()
    for number in range(100):
        count.reject(f'reason {number}')
    assert len(count.rejected) <= 21
    assert count.rejected.total() == 100


def succeed() -> str:
    return 'saved to hall.yaml'


def refuse() -> str:
    raise MessageError('nothing is known yet; look around first')


def fail_to_serve() -> str:
    raise ValueError("'/' has\nan empty name")


@pytest.mark.parametrize(
    ('work', 'success', 'message'),
    [
        (succeed, True, 'saved to hall.yaml'),
        (refuse, False, 'nothing is known yet; look around first'),
        (fail_to_serve, False, "ValueError: '/' has an empty name"),
    ],
)
def test_every_call_is_answered_in_one_line(
    graph: IsolatedGraph, work: object, success: bool, message: str
) -> None:
    node = graph.add(lambda **options: Node('server', **options))
    guard = CallbackGuard(node)
    create_trigger_service(node, guard, '~/save', work)
    asker = graph.add(lambda **options: Node('asker', **options))
    client = asker.create_client(Trigger, '/server/save')
    assert graph.spin_until(client.service_is_ready)
    for _ in range(2):
        future = client.call_async(Trigger.Request())
        assert graph.spin_until(future.done)
        assert (future.result().success, future.result().message) == (success, message)
    assert (guard.counts['~/save'].received, guard.counts['~/save'].rejected.total()) == (
        2,
        0 if success else 2,
    )
