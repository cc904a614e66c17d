"""The beat of the symbols, found from the frames alone.

Lamp and camera share no clock. For each time tau at which symbols may begin (modulo their duration), the frames fall
into symbols; each symbol explains its frames at best by the likelihood of its best hypothesis; the sum over all
symbols is tau's score. A generalised likelihood ratio, so frames may be missing or unevenly spaced.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def symbol_likelihoods(
    stamps: NDArray[np.float64],
    tables: NDArray[np.float32],
    begin: float,
    duration: float,
    count: int,
) -> NDArray[np.float64]:
    """Sum the frames' log likelihoods over each symbol.

    Args:
        stamps: shape (f,), of the frames [s].
        tables: shape (f, bins, symbols), log likelihood of each frame for each place within a symbol's duration where
            it may have been taken, and each symbol.
        begin: of the first symbol [s].
        duration: of a symbol [s].
        count: of symbols.

    Returns:
        Shape (count, symbols), log likelihoods, 0 where a symbol has no frames.
    """
    bins, symbols = tables.shape[1:]
    sums = np.zeros((count, symbols))
    for f in range(len(stamps)):
        place = (stamps[f] - begin) / duration
        index = int(np.floor(place))
        if 0 <= index < count:
            column = min(int((place - index) * bins), bins - 1)
            for s in range(symbols):
                sums[index, s] += tables[f, column, s]
    return sums


@njit(cache=True)
def beat_scores(
    stamps: NDArray[np.float64],
    tables: NDArray[np.float32],
    duration: float,
    begins: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the score of each beat, shape (n,).

    Args:
        stamps: as in `symbol_likelihoods`.
        tables: as in `symbol_likelihoods`.
        duration: of a symbol [s].
        begins: shape (n,), a time at which a symbol begins [s].
    """
    bins, symbols = tables.shape[1:]
    scores = np.zeros(len(begins))
    sums = np.zeros((len(begins), symbols))
    lasts = np.zeros(len(begins), np.int64)
    # Frame by frame, for neighbouring beats read neighbouring columns of its table.
    for f in range(len(stamps)):
        for i in range(len(begins)):
            place = (stamps[f] - begins[i]) / duration
            index = np.int64(np.floor(place))
            if f > 0 and index != lasts[i]:
                best = sums[i, 0]
                for s in range(symbols):
                    best = max(best, sums[i, s])
                    sums[i, s] = 0.0
                scores[i] += best
            lasts[i] = index
            column = min(int((place - index) * bins), bins - 1)
            for s in range(symbols):
                sums[i, s] += tables[f, column, s]
    for i in range(len(begins)):
        scores[i] += sums[i].max()
    return scores
