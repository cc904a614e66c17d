"""Trigger services whose errors are returned to the caller and do not end the node."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from shirube_ros.message_guard import MessageGuard


def offer_trigger(node: Node, guard: MessageGuard, name: str, work: Callable[[], str]) -> None:
    """Create a service of type Trigger.

    Args:
        node: node that offers the service.
        guard: counts the calls and catches their errors, which are returned to the caller.
        name: name of the service.
        work: function that serves a call; returns the response message, one line.
    """

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        def note() -> None:
            response.message = work()

        fault = guard.run(name, note)
        response.success = fault is None
        if fault is not None:
            response.message = fault
        return response

    node.create_service(Trigger, name, answer)
