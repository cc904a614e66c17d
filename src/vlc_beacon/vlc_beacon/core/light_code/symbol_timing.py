"""Symbol timing recovery from the frames alone.

Lamp and camera share no clock. For each candidate symbol phase tau (modulo the symbol duration), frames are assigned to
symbols; the score of tau is the sum over all symbols of the log-likelihood of their best hypothesis. This is a
generalised likelihood ratio, so frames may be missing or unevenly spaced.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray


class FrameBuffer:
    """Stamps and log-likelihood tables, shape (bins, symbols), of frames, oldest first."""

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


@njit(cache=True)
def symbol_log_likelihoods(
    stamps: NDArray[np.float64], tables: NDArray[np.float32], begin: float, duration: float, count: int
) -> NDArray[np.float64]:
    """Sum the log-likelihoods of the frames over each symbol.

    Args:
        stamps: stamps of the frames, shape (f,) [s].
        tables: log-likelihood of each frame for each position within a symbol and each symbol, shape
            (f, bins, symbols).
        begin: start of the first symbol [s].
        duration: duration of a symbol [s].
        count: number of symbols.

    Returns:
        log-likelihoods, shape (count, symbols), 0 if a symbol has no frames.
    """
    bins, symbols = tables.shape[1:]
    sums = np.zeros((count, symbols))
    for f in range(len(stamps)):
        position = (stamps[f] - begin) / duration
        index = int(np.floor(position))
        if 0 <= index < count:
            column = min(int((position - index) * bins), bins - 1)
            for s in range(symbols):
                sums[index, s] += tables[f, column, s]
    return sums


@njit(cache=True)
def timing_scores(
    stamps: NDArray[np.float64], tables: NDArray[np.float32], duration: float, starts: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the score of each candidate start of a symbol, shape (n,); see `symbol_log_likelihoods`."""
    bins, symbols = tables.shape[1:]
    scores = np.zeros(len(starts))
    sums = np.zeros((len(starts), symbols))
    lasts = np.zeros(len(starts), np.int64)
    # Loop over frames first: neighbouring phases read neighbouring columns of a table.
    for f in range(len(stamps)):
        for i in range(len(starts)):
            position = (stamps[f] - starts[i]) / duration
            index = np.int64(np.floor(position))
            if f > 0 and index != lasts[i]:
                best = sums[i, 0]
                for s in range(symbols):
                    best = max(best, sums[i, s])
                    sums[i, s] = 0.0
                scores[i] += best
            lasts[i] = index
            column = min(int((position - index) * bins), bins - 1)
            for s in range(symbols):
                sums[i, s] += tables[f, column, s]
    for i in range(len(starts)):
        scores[i] += sums[i].max()
    return scores
