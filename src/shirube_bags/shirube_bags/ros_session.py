"""A node, its executor and a stop event for a command, with clean shutdown."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Provide an event that SIGINT and SIGTERM set; restore the previous handlers at the end."""
    stop = threading.Event()
    signals = (signal.SIGINT, signal.SIGTERM)
    former = {each: signal.signal(each, lambda _number, _frame: stop.set()) for each in signals}
    try:
        yield stop
    finally:
        for each, handler in former.items():
            signal.signal(each, handler)


@dataclass(frozen=True)
class RosSession:
    """A node and the executor that spins it."""

    node: Node
    executor: SingleThreadedExecutor


@contextmanager
def ros_session(name: str, arguments: Sequence[str], use_sim_time: bool = False) -> Iterator[RosSession]:
    """Create a node from a command line with ``--ros-args``; the caller handles signals (`stop_on_signals`)."""
    context = Context()
    rclpy.init(args=list(arguments), context=context, signal_handler_options=SignalHandlerOptions.NO)
    try:
        override = [rclpy.Parameter('use_sim_time', value=True)] if use_sim_time else []
        node = Node(name, context=context, parameter_overrides=override)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        try:
            yield RosSession(node, executor)
        finally:
            executor.shutdown()
            node.destroy_node()
    finally:
        context.try_shutdown()
