"""The guard of callbacks and services."""

from typing import Any

import pytest
from node_testing import IsolatedGraph
from std_srvs.srv import Trigger

from shirube_ros.callback_guard import CallbackGuard, TopicCount, create_trigger_service
from shirube_ros.errors import MessageError


def reject(message: str) -> None:
    raise MessageError(message)


def fail(_: Any) -> None:
    raise ZeroDivisionError('by zero')


@pytest.mark.parametrize(
    ('work', 'errors', 'rejected'),
    [
        (str.upper, (), {}),
        (reject, (), {'too dark': 2, 'too small': 1}),
        (fail, (), {'ZeroDivisionError in image': 3}),  # a mistake does not end the node
        (fail, (ZeroDivisionError,), {'by zero': 3}),
    ],
)
def test_messages_are_counted_and_the_refused_ones_by_reason(
    graph: IsolatedGraph, work: Any, errors: tuple[type[Exception], ...], rejected: dict[str, int]
) -> None:
    guard, seen = CallbackGuard(graph.node('guarded'), errors), []
    take = guard.guard('image', lambda message: seen.append(work(message)))
    for word in ('too dark', 'too dark', 'too small'):
        take(word)
    assert seen == ([] if rejected else ['TOO DARK', 'TOO DARK', 'TOO SMALL'])
    count = guard.counts['image']
    assert (count.received, count.rejected) == (3, rejected)
    assert not rejected or count.latest_rejection == list(rejected)[-1]


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
def test_every_call_is_answered_in_one_line(graph: IsolatedGraph, work: object, success: bool, message: str) -> None:
    node = graph.node('server')
    guard = CallbackGuard(node)
    create_trigger_service(node, guard, '~/save', work)
    asker = graph.node('asker')
    client = asker.create_client(Trigger, '/server/save')
    assert graph.spin_until(client.service_is_ready)
    for _ in range(2):
        future = client.call_async(Trigger.Request())
        assert graph.spin_until(future.done)
        assert (future.result().success, future.result().message) == (success, message)
    count = guard.counts['~/save']
    assert (count.received, count.rejected.total()) == (2, 0 if success else 2)
