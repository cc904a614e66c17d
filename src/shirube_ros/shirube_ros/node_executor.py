"""The executor of a node in a process of its own."""

from __future__ import annotations

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor

try:
    from rclpy.experimental import EventsExecutor
except ImportError:  # before rclpy 7.1.5
    EventsExecutor = None


def node_executor(context: rclpy.Context | None = None) -> Executor:
    """Return an EventsExecutor, which calls callbacks one at a time in the order of their events.

    A SingleThreadedExecutor polls all entities of a node before each callback, which costs more than most callbacks: a
    node that receives a hundred small messages a second then needs two to three times the CPU time. Subscriptions whose
    callbacks take the MessageInfo need a SingleThreadedExecutor: rclpy's EventsExecutor fails with them.

    Args:
        context: context of the nodes, None for the default one.
    """
    if EventsExecutor is None:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)
