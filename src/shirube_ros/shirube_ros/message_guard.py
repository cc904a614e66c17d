"""Keeps a node alive whatever it is sent, and counts what it could not use."""

from __future__ import annotations

import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rclpy.node import Node

from shirube_ros.message_error import MessageError

_MOST_REASONS = 20  # distinct ones a topic; more would flood the diagnostics
_OTHER_REASONS = 'other reasons'


@dataclass
class TopicCount:
    """Messages of one topic.

    Attributes:
        received: number of messages received.
        refused: number of messages that could not be used, by reason.
        latest_refusal: reason of the latest refusal that has not been reported yet, else None.
    """

    received: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    latest_refusal: str | None = None

    def refuse(self, reason: str) -> bool:
        """Count a refusal; return whether its reason is new."""
        is_new = reason not in self.refused
        self.latest_refusal = reason
        if is_new and len(self.refused) >= _MOST_REASONS:
            self.refused[_OTHER_REASONS] += 1
            return False
        self.refused[reason] += 1
        return is_new


class MessageGuard:
    """Wraps a node's callbacks so that none of them can end the node."""

    def __init__(self, node: Node, package_errors: tuple[type[Exception], ...] = ()) -> None:
        """Start without counts.

        Args:
            node: the node that is guarded.
            package_errors: errors of the node's own package that malformed input raises.
        """
        self._node = node
        self._input_errors: tuple[type[Exception], ...] = (MessageError, *package_errors)
        self.counts: dict[str, TopicCount] = {}

    def guard(self, topic: str, callback: Callable[[Any], None]) -> Callable[[Any], None]:
        """Return the callback with its errors caught, counted and logged once for each reason.

        Args:
            topic: name under which messages are counted.
            callback: a subscription's callback. A MessageError or an error of the package is the message's
                fault; any other error is a fault of the program and is logged with its traceback.
        """
        self.counts.setdefault(topic, TopicCount())

        def guarded(message: object) -> None:
            self.run(topic, lambda: callback(message))

        return guarded

    def run(self, topic: str, work: Callable[[], None]) -> str | None:
        """Do some work as `guard` does; return None if it went well, else one line that says why not.

        Args:
            topic: name under which the work is counted.
            work: to be done.
        """
        count = self.counts.setdefault(topic, TopicCount())
        count.received += 1
        try:
            work()
        except self._input_errors as error:
            if count.refuse(str(error)):
                self._node.get_logger().warning(f'message refused: {error}')
            return str(error)
        except Exception as error:  # noqa: BLE001 a fault of ours must not end the robot's node
            if self._node.context.ok() and count.refuse(f'{type(error).__name__} in {topic}'):
                self._log_fault(topic)  # else the program is ending and publishers are gone
            return ' '.join(f'{type(error).__name__}: {error}'.split())
        return None

    def _log_fault(self, topic: str) -> None:
        self._node.get_logger().error(f'fault while working on {topic}:\n{traceback.format_exc()}')
