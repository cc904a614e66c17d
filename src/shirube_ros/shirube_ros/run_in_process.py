"""Calls a node's main function within the test process, as from a command line."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable


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
