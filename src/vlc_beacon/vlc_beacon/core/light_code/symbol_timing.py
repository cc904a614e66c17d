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
        self.stamps, self.tables = np.empty(0), np.empty((0, bins, symbols), np.float32)

    def add(self, stamps: NDArray[np.float64], tables: NDArray[np.float32]) -> None:
        """Append frames, shapes (n,) and (n, bins, symbols); stamps increase [s]."""
        self.stamps, self.tables = np.append(self.stamps, stamps), np.concatenate([self.tables, tables])

    def drop_before(self, stamp: float) -> None:
        """Drop frames before a stamp [s]."""
        first = np.searchsorted(self.stamps, stamp)
        self.stamps, self.tables = self.stamps[first:], self.tables[first:]


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
