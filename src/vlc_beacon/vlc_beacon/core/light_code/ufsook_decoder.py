"""Brightness of a lamp's halves, frame by frame, to packets (see `ufsook`)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.light_code.ufsook import UFSOOK, expected_levels
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

BINS = 240
"""Places within a symbol: steps of 0.14 ms, a thirtieth of a blink."""
TIMING_SIGMA = 1.2e-4
"""Uncertainty of when within its symbol a frame was taken: jitter of the stamps and of the beat [s]."""
NOISE_SIGMA = 0.1
"""Standard deviation of the brightness."""
SURPRISE_MAX = 10.0
"""A frame speaks against a symbol by no more than this log likelihood: something may have passed the lamp."""


class UfsookDecoder:
    """Decodes one lamp."""

    def __init__(self) -> None:
        self._receiver = SymbolReceiver(UFSOOK, symbols=4, bins=BINS, candidates=BINS)

    def add_frame(self, stamp: float, brightness: ArrayLike, exposure: float) -> list[ReceivedPacket]:
        """Take a frame and return the packets that it completes.

        Args:
            stamp: when its exposure began [s].
            brightness: shape (2,), of the panel's halves, over their full brightness.
            exposure: of the frame [s].
        """
        seen = np.asarray(brightness, float)
        if not np.isfinite(seen).all():
            return []
        return self._receiver.add(stamp, _frame_table(*_model(round(exposure, 6)), seen[0], seen[1]))


@njit(cache=True)
def _frame_table(
    means: NDArray[np.float64],
    precisions: NDArray[np.float64],
    constants: NDArray[np.float64],
    seen_0: float,
    seen_1: float,
) -> NDArray[np.float32]:
    """Return the log likelihood of a frame for each symbol and bin, shape (symbols, BINS)."""
    symbols, bins = constants.shape
    table = np.empty((symbols, bins), np.float32)
    for s in range(symbols):
        for b in range(bins):
            error_0 = precisions[s, b, 0] * (means[s, b, 0] - seen_0) ** 2
            error_1 = precisions[s, b, 1] * (means[s, b, 1] - seen_1) ** 2
            table[s, b] = max(constants[s, b] - 0.5 * (error_0 + error_1), -SURPRISE_MAX)
    return table


@lru_cache(maxsize=64)
def _model(exposure: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return mean and inverse variance, shape (symbols, BINS, 2), and the constant of the log likelihood."""
    means, variances = expected_levels(exposure, BINS, TIMING_SIGMA)
    precisions = 1.0 / (variances + NOISE_SIGMA**2)
    return means, precisions, 0.5 * np.log(precisions * NOISE_SIGMA**2).sum(axis=2)
