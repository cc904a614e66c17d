"""A node's main function called within a test, as from a command line, but without a process of its own."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable


def start_here(main: Callable[[], int], *arguments: str) -> int:
    """Call the main function of a node whose start is refused.

    Args:
        main: of the node.
        arguments: of the command line.

    Returns:
        the exit code.
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
