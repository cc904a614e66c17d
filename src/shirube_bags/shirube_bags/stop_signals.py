"""Handles SIGINT and SIGTERM by a stop event, so that files are closed and the exit code is 0."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def stop_on_signals() -> Iterator[threading.Event]:
    """Provide an event that SIGINT and SIGTERM set; restore the previous handlers at the end."""
    stop = threading.Event()
    signals = (signal.SIGINT, signal.SIGTERM)
    former = {each: signal.signal(each, lambda _number, _frame: stop.set()) for each in signals}
    try:
        yield stop
    finally:
        for each, handler in former.items():
            signal.signal(each, handler)
