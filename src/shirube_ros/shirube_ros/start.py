"""Main functions of the nodes: a signal during the imports, which take seconds, ends the process at once."""

import os
import signal
import sys
from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import NoReturn


def __getattr__(package: str) -> Callable[[], NoReturn]:
    """Return the main function of a package's node, for an entry point: ``shirube_ros.start:motor_bridge``."""
    if package.startswith('_'):
        raise AttributeError(package)
    return partial(run_main, f'{package}.node')


def run_main(module: str) -> NoReturn:
    """Import a module, run its ``main`` and end the process; a signal during the import gives exit code 0."""
    for number in (signal.SIGINT, signal.SIGTERM):
        # An exception would be lost or changed in imported C code.
        signal.signal(number, lambda *_: os._exit(0))
    code = int(import_module(module).main())
    sys.stdout.flush()
    sys.stderr.flush()
    # Without Python's own shutdown: after numba has compiled, it takes seconds, and ROS launch kills the process then.
    os._exit(code)
