"""Main functions of the nodes: a signal during the imports, which take seconds, ends the process at once."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from functools import partial
from importlib import import_module


def __getattr__(package: str) -> Callable[[], int]:
    """Return the main function of a package's node, for an entry point: ``shirube_ros.start:motor_bridge``."""
    if package.startswith('_'):
        raise AttributeError(package)
    return partial(run_main, f'{package}.node')


def run_main(module: str) -> int:
    """Import a module and run its ``main``; a signal meanwhile gives exit code 0 without a traceback."""
    for number in (signal.SIGINT, signal.SIGTERM):
        # An exception would be lost or changed in imported C code.
        signal.signal(number, lambda *_: os._exit(0))
    return int(import_module(module).main())
