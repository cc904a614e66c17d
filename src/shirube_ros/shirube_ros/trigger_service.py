"""Trigger services whose errors are returned to the caller and do not end the node."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from shirube_ros.callback_guard import CallbackGuard


def create_trigger_service(node: Node, guard: CallbackGuard, name: str, function: Callable[[], str]) -> None:
    """Create a service of type Trigger.

    Args:
        node: node that offers the service.
        guard: counts the calls and catches their errors, which are returned to the caller.
        name: name of the service.
        function: function that serves a call; returns the response message, one line.
    """

    def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        def call() -> None:
            response.message = function()

        fault = guard.run(name, call)
        response.success = fault is None
        if fault is not None:
            response.message = fault
        return response

    node.create_service(Trigger, name, respond)
