"""Catches errors of callbacks and services, so that no message ends the node, and counts rejected messages."""

import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node
from std_srvs.srv import Trigger

from shirube_ros.errors import MessageError

_REASONS_MAX = 20  # distinct reasons per topic; more would flood the diagnostics
_OTHER_REASONS = 'other reasons'


@dataclass
class TopicCount:
    """Received messages of a topic, rejected ones by reason, and the latest reason not yet reported."""

    received: int = 0
    rejected: Counter[str] = field(default_factory=Counter)
    latest_rejection: str | None = None

    def reject(self, reason: str) -> bool:
        """Count a rejected message; return whether the reason is new."""
        is_new = reason not in self.rejected
        self.latest_rejection = reason
        if is_new and len(self.rejected) >= _REASONS_MAX:
            self.rejected[_OTHER_REASONS] += 1
            return False
        self.rejected[reason] += 1
        return is_new


class CallbackGuard:
    """Wraps a node's callbacks so that none of them can end the node.

    Attributes:
        counts: message counts by topic.
        is_active: whether callbacks are called; an inactive node drops messages and refuses services.
    """

    def __init__(self, node: Node, package_errors: tuple[type[Exception], ...] = ()) -> None:
        """Start without counts; ``package_errors`` are those of the node's package for malformed input."""
        self._node = node
        self._input_errors: tuple[type[Exception], ...] = (MessageError, *package_errors)
        self.counts: dict[str, TopicCount] = {}
        self.is_active = True

    def guard(
        self, topic: str, callback: Callable[[Any], None], *, while_inactive: bool = False
    ) -> Callable[[Any], None]:
        """Wrap a subscription's callback: errors are caught, counted by topic, and logged once per reason.

        A MessageError or an error of the package rejects the message; any other error is a bug, logged with traceback.
        """
        self.counts.setdefault(topic, TopicCount())

        def guarded(message: object) -> None:
            if self.is_active or while_inactive:
                self.run(topic, lambda: callback(message))

        return guarded

    def run(self, topic: str, function: Callable[[], None]) -> str | None:
        """Call a function as `guard` does; return None on success, else an error message of one line."""
        count = self.counts.setdefault(topic, TopicCount())
        count.received += 1
        try:
            function()
        except self._input_errors as error:
            if count.reject(str(error)):
                self._node.get_logger().warning(f'message rejected: {error}')
            return str(error)
        except Exception as error:  # noqa: BLE001 a bug must not end the robot's node
            if self._node.context.ok() and count.reject(f'{type(error).__name__} in {topic}'):
                # Otherwise the node is shutting down.
                self._node.get_logger().error(f'internal error in callback of {topic}:\n{traceback.format_exc()}')
            return ' '.join(f'{type(error).__name__}: {error}'.split())
        return None


def create_trigger_service(node: Node, guard: CallbackGuard, name: str, function: Callable[[], str]) -> None:
    """Create a service that replies with the function's line or error; the guard counts the errors."""

    def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        def call() -> None:
            response.message = function()

        fault = guard.run(name, call) if guard.is_active else 'the node is not active; activate it'
        response.success = fault is None
        if fault is not None:
            response.message = fault
        return response

    node.create_service(Trigger, name, respond)
