"""How much of a known number of things is done: a bar on a terminal, plain lines elsewhere."""

import sys
import threading
import time
from types import TracebackType
from typing import Self

from tqdm import tqdm

_LINE_INTERVAL = 10.0
"""Time between two lines where the output is not a terminal [s]."""


class Progress:
    """Counts and shows what is done; to be used in a `with` statement, from any thread."""

    def __init__(self, title: str, total: int) -> None:
        """Prepare.

        Args:
            title: what is being done.
            total: how many things there are.
        """
        self._title, self._total, self._done = title, total, 0
        self._lock = threading.Lock()
        self._bar: tqdm | None = None
        self._next_line = 0.0

    def __enter__(self) -> Self:
        """Show that nothing is done yet."""
        if sys.stderr.isatty():
            # tqdm draws with ASCII characters where the terminal's encoding has no others.
            self._bar = tqdm(
                desc=self._title, total=self._total, bar_format='{desc}: {n}/{total} |{bar}| {elapsed}'
            )
        else:
            self._print_line()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Show how far it came."""
        if self._bar is not None:
            self._bar.close()
        else:
            self._print_line()

    def advance(self, count: int) -> None:
        """Add things that are done."""
        with self._lock:
            self._done += count
            if self._bar is not None:
                self._bar.update(count)
            elif time.monotonic() >= self._next_line:
                self._print_line()

    def _print_line(self) -> None:
        self._next_line = time.monotonic() + _LINE_INTERVAL
        print(f'{self._title}: {self._done} of {self._total}', file=sys.stderr, flush=True)
