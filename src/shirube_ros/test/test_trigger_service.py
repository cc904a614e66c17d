"""A failing service call is answered with the error, and the node keeps running."""

from __future__ import annotations

import pytest
from node_testing import IsolatedGraph
from rclpy.node import Node
from std_srvs.srv import Trigger

from shirube_ros.callback_guard import CallbackGuard, create_trigger_service
from shirube_ros.errors import MessageError


def succeed() -> str:
    return 'saved to hall.yaml'


def refuse() -> str:
    raise MessageError('nothing is known yet; look around first')


def fail() -> str:
    raise ValueError("'/' has\nan empty name")


@pytest.mark.parametrize(
    ('work', 'success', 'message'),
    [
        (succeed, True, 'saved to hall.yaml'),
        (refuse, False, 'nothing is known yet; look around first'),
        (fail, False, "ValueError: '/' has an empty name"),
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
