"""The executor of a node that runs alone in its process."""

from __future__ import annotations

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # before rclpy 7.1.5
    EventsExecutor = None


def node_executor(context: rclpy.Context | None = None) -> Executor:
    """Return an executor that calls one callback after the other, in the order in which their events came.

    The usual one looks at everything a node has before each callback, which costs more than most callbacks: a node that
    gets a hundred small messages a second then works two to three times as long. Subscriptions whose callbacks take the
    message's info (when it was sent) need the usual one: rclpy's EventsExecutor fails at them.

    Args:
        context: of the nodes, None for the default one.
    """
    if EventsExecutor is None:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)
