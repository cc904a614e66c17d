"""The space bar of a terminal as a switch between replay and pause."""

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

PAUSE_KEY = b' '


@contextmanager
def pause_key(on_change: Callable[[bool], None]) -> Iterator[Callable[[], bool]]:
    """Provide a function that reads the keys and returns whether the replay is paused.

    It always returns False where no terminal is in the foreground. The terminal's mode is restored at the end.

    Args:
        on_change: called with the new state after each key.
    """
    terminal = sys.stdin.fileno() if is_in_foreground() else None
    paused = False

    def is_paused() -> bool:
        nonlocal paused
        while terminal is not None and select.select([terminal], [], [], 0.0)[0]:
            keys = os.read(terminal, 1024)
            if not keys:  # the terminal is gone
                break
            if keys.count(PAUSE_KEY) % 2:
                paused = not paused
                on_change(paused)
        return paused

    if terminal is None:
        yield is_paused
        return
    former = termios.tcgetattr(terminal)
    try:
        tty.setcbreak(terminal)
        yield is_paused
    finally:
        termios.tcsetattr(terminal, termios.TCSADRAIN, former)


def is_in_foreground() -> bool:
    """Return whether stdin is a terminal of which this process may read; a job in the background would be stopped."""
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except (AttributeError, OSError, ValueError):  # no stdin, closed, or no terminal
        return False
