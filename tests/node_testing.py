"""Nodes within the process of a test: an isolated ROS graph, main functions that fail to start, beginnings of bags."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import TypeVar

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_writer import BagWriter
from shirube_bringup.free_domain import free_domain
from shirube_ros.node import node_executor

AnyNode = TypeVar('AnyNode', bound=Node)


class IsolatedGraph:
    """Nodes that discover only each other."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self._executor = node_executor(context)
        self._nodes: list[Node] = []

    def add(self, create_node: Callable[..., AnyNode], **parameters: object) -> AnyNode:
        """Create a node in this graph, spun by ``spin_until``.

        Args:
            create_node: node class, or function that passes its keywords on to ``rclpy.node.Node``.
            parameters: parameter overrides, as from the command line.
        """
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        node = create_node(context=self.context, parameter_overrides=overrides)
        self._nodes.append(node)
        self._executor.add_node(node)
        return node

    def spin_until(self, is_done: Callable[[], bool], timeout: float = 10.0) -> bool:
        """Spin until a condition is true; return False after ``timeout`` [s]."""
        end = monotonic() + timeout
        while not is_done():
            if monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=0.05)
        return True

    def close(self) -> None:
        """Destroy the nodes."""
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()


@contextmanager
def isolated_graph() -> Iterator[IsolatedGraph]:
    """Open a graph on a domain that no other test on this host uses."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    context = Context()
    with free_domain() as domain:
        rclpy.init(context=context, domain_id=domain)
        graph = IsolatedGraph(context)
        try:
            yield graph
        finally:
            graph.close()
            context.try_shutdown()


def run_in_process(main: Callable[[], int], *arguments: str) -> int:
    """Call the main function of a node that fails to start.

    Args:
        main: main function of the node.
        arguments: command line arguments.

    Returns:
        exit code.
    """
    given = sys.argv
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    sys.argv = ['node', *arguments]
    try:
        return main()
    finally:
        sys.argv = given
        for number, handler in handlers.items():
            signal.signal(number, handler)


def first_seconds(path: Path, seconds: float, source: Path) -> Path:
    """Copy the beginning of a bag."""
    with BagReader(source) as bag, BagWriter(path) as copy:
        for raw in bag.messages():
            if raw.stamp_ns > bag.start_ns + 1e9 * seconds:
                break
            copy.write_raw(raw.topic, raw.msgtype, raw.raw, raw.stamp_ns)
    return path
