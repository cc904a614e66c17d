"""A program for the tests of safe_main: a node with one parameter that may refuse to start."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

from rclpy.node import Node

from shirube_core.settings import setting
from shirube_ros.node import run_node
from shirube_ros.parameters import declare_parameters


class FloorError(RuntimeError):
    """The error of an imagined package."""


@dataclass(frozen=True)
class MinimalSettings:
    rate: float = setting(0.5, 'rate', minimum=0.0, maximum=1.0)
    fault: str = setting('', 'what goes wrong at start')


def _work_long() -> None:
    """Be busy for a minute. In short naps: a signal just before a nap does not end it, only what comes after it."""
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        time.sleep(0.05)


class MinimalNode(Node):
    def __init__(self) -> None:
        super().__init__('minimal')
        settings = declare_parameters(self, MinimalSettings)
        if settings.fault == 'file':
            Path('no_such_file.csv').read_text()
        if settings.fault == 'package':
            raise FloorError('map.csv is empty;\nbuild a map')
        if settings.fault == 'program':
            raise ZeroDivisionError('a mistake')
        if settings.fault == 'slow':
            sys.stdout.write('alive\n')
            sys.stdout.flush()
            _work_long()
        if settings.fault == 'compiling':
            self._compile()
        self._fault = settings.fault
        self.create_timer(0.05, self._live)

    def _compile(self) -> None:
        """Stand for a compiler at start, which is interrupted, but by its own error."""
        sys.stdout.write('alive\n')
        sys.stdout.flush()
        try:
            _work_long()
        except KeyboardInterrupt as interrupt:
            raise SystemError('a compiled call returned a result with an exception set') from interrupt

    def _live(self) -> None:
        sys.stdout.write('alive\n')
        sys.stdout.flush()
        if self._fault == 'later':
            raise ZeroDivisionError('a mistake')
        if self._fault == 'busy':
            self._work()

    def _work(self) -> None:
        """Stand for compiled code: an interrupt makes an error of its own of it."""
        try:
            time.sleep(0.5)
        except KeyboardInterrupt as interrupt:
            raise SystemError('a compiled call returned a result with an exception set') from interrupt
        sys.stdout.write('worked to the end\n')

    def stop(self) -> None:
        sys.stdout.write('stopped while publishers work\n' if self.context.ok() else 'stopped too late\n')


if __name__ == '__main__':
    sys.exit(run_node('minimal', MinimalNode, (FloorError,)))
