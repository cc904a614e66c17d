"""A node in a process of its own, for benchmarks that play its robot."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from time import monotonic

import rclpy
from rclpy.node import Node

_START_SECONDS = 180.0


@contextmanager
def running_node(module: str, parameters: Mapping[str, object]) -> Iterator[Callable[[Node, Callable[[], bool]], None]]:
    """Start a node with parameters, and rclpy here; yield a function that spins a node until a condition is true."""
    arguments = [part for name, value in parameters.items() for part in ('-p', f'{name}:={value}')]
    command = [sys.executable, '-m', module, '--ros-args', *arguments]
    process = subprocess.Popen(command, env=os.environ, stderr=subprocess.DEVNULL)
    rclpy.init()

    def wait_until(node: Node, is_ready: Callable[[], bool]) -> None:
        end = monotonic() + _START_SECONDS
        while not is_ready():
            if monotonic() > end or process.poll() is not None:
                raise RuntimeError('the node does not start')
            rclpy.spin_once(node, timeout_sec=0.1)

    try:
        yield wait_until
    finally:
        process.terminate()
        process.wait()
        rclpy.try_shutdown()
