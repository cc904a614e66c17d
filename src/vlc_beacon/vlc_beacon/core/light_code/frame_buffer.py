"""Buffer of recent frames in contiguous memory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class FrameBuffer:
    """Stamps and log-likelihood tables of frames, oldest first.

    Args:
        bins: number of bins of a table.
        symbols: number of symbols of a table.
    """

    def __init__(self, bins: int, symbols: int) -> None:
        self._stamps = np.zeros(64)
        self._tables = np.zeros((64, bins, symbols), np.float32)
        self._first = self._end = 0

    @property
    def stamps(self) -> NDArray[np.float64]:
        """Stamps, shape (n,), increasing [s]; a view."""
        return self._stamps[self._first : self._end]

    @property
    def tables(self) -> NDArray[np.float32]:
        """Tables, shape (n, bins, symbols); a view."""
        return self._tables[self._first : self._end]

    def add(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> None:
        """Append frames, shapes (n,) and (n, bins, symbols)."""
        while self._end + len(stamps) > len(self._stamps):
            self._make_room()
        end = self._end + len(stamps)
        self._stamps[self._end : end], self._tables[self._end : end] = stamps, tables
        self._end = end

    def drop_before(self, stamp: float) -> None:
        """Drop frames before a stamp [s]."""
        self._first += int(np.searchsorted(self.stamps, stamp))

    def _make_room(self) -> None:
        """Make room at the end: reuse dropped space if it is half of the buffer, else grow."""
        stamps, tables = self.stamps, self.tables
        if len(stamps) > len(self._stamps) // 2 or self._first == 0:
            self._stamps = np.zeros(2 * len(self._stamps))
            self._tables = np.zeros((len(self._stamps), *tables.shape[1:]), np.float32)
        self._stamps[: len(stamps)], self._tables[: len(stamps)] = stamps.copy(), tables.copy()
        self._first, self._end = 0, len(stamps)
