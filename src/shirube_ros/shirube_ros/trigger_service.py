"""Services without arguments, whose faults are answers and not the end of the node."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import Trigger

from shirube_ros.message_guard import MessageGuard


def offer_trigger(node: Node, guard: MessageGuard, name: str, work: Callable[[], str]) -> None:
    """Offer a service of type Trigger.

    Args:
        node: the node that offers it.
        guard: counts the calls and catches their errors; the caller is told them.
        name: of the service.
        work: what is done at a call; returns one line that says what was done.
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
