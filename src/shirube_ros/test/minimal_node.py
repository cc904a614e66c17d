"""A program for the tests of safe_main: a node with one parameter that may refuse to start."""

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
    rate: float = setting(0.5, 'rate', limits=(0.0, 1.0))
    fault: str = setting('', 'what goes wrong at start')


def _say(line: str) -> None:
    sys.stdout.write(f'{line}\n')
    sys.stdout.flush()


def _work(seconds: float) -> None:
    """Be busy, in short naps: a signal just before a nap does not end it, only what comes after it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.05)


def _run_compiled(seconds: float) -> None:
    """Stand for a compiler or compiled code: an interrupt makes an error of its own of it."""
    try:
        _work(seconds)
    except KeyboardInterrupt as interrupt:
        raise SystemError('a compiled call returned a result with an exception set') from interrupt


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
        if settings.fault in ('slow', 'compiling'):
            _say('alive')
            (_work if settings.fault == 'slow' else _run_compiled)(60.0)
        self._fault = settings.fault
        self.create_timer(0.05, self._live)

    def _live(self) -> None:
        _say('alive')
        if self._fault == 'later':
            raise ZeroDivisionError('a mistake')
        if self._fault == 'busy':
            _run_compiled(0.5)
            _say('worked to the end')

    def stop(self) -> None:
        _say('stopped while publishers work' if self.context.ok() else 'stopped too late')


if __name__ == '__main__':
    sys.exit(run_node('minimal', MinimalNode, (FloorError,)))
