"""SIGINT and SIGTERM as a wish to stop, so that files are closed and programs end with exit code 0."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Give an event that SIGINT and SIGTERM set; the former handlers come back at the end."""
    stop = threading.Event()
    signals = (signal.SIGINT, signal.SIGTERM)
    former = {each: signal.signal(each, lambda _number, _frame: stop.set()) for each in signals}
    try:
        yield stop
    finally:
        for each, handler in former.items():
            signal.signal(each, handler)
