"""Decodes UFSOOK packets from the brightness of a lamp's halves (see `ufsook`)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.light_code.ufsook import UFSOOK, expected_levels
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

BINS = 240
"""Positions within a symbol: steps of 0.14 ms, 1/30 of a cycle."""
TIMING_SIGMA = 1.2e-4
"""Standard deviation of a frame's position in its symbol, from jitter of stamps and symbol timing [s]."""
NOISE_SIGMA = 0.1
"""Standard deviation of the brightness."""
PENALTY_MAX = 10.0
"""Maximum penalty of one frame in log-likelihood: the lamp may have been occluded."""


class UfsookDecoder:
    """Decodes one lamp."""

    def __init__(self) -> None:
        self._receiver = SymbolReceiver(UFSOOK, symbols=4, bins=BINS, candidates=BINS)

    def add_frame(self, stamp: float, brightness: ArrayLike, exposure: float) -> list[ReceivedPacket]:
        """Add a frame and return the packets that it completes; see `add_frames`."""
        return self.add_frames(np.array([stamp]), np.asarray(brightness, float)[None], exposure)

    def add_frames(
        self, stamps: NDArray[np.float64], brightness: NDArray[np.float64], exposure: float
    ) -> list[ReceivedPacket]:
        """Add frames and return the packets that they complete.

        Args:
            stamps: start of the exposures, shape (n,) [s].
            brightness: brightness of the halves relative to full light, shape (n, 2). Frames with NaN are skipped.
            exposure: exposure of the frames [s].
        """
        kept = np.isfinite(brightness).all(axis=1)
        tables = _frame_tables(*_likelihood_model(round(exposure, 6)), brightness[kept])
        return self._receiver.add(stamps[kept], tables)


@njit(cache=True)
def _frame_tables(
    means: NDArray[np.float64],
    precisions: NDArray[np.float64],
    constants: NDArray[np.float64],
    brightness: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Return the log-likelihood of each frame for each bin and symbol, shape (n, BINS, symbols)."""
    bins, symbols = constants.shape
    tables = np.empty((len(brightness), bins, symbols), np.float32)
    for f in range(len(brightness)):
        for b in range(bins):
            for s in range(symbols):
                error_0 = precisions[b, s, 0] * (means[b, s, 0] - brightness[f, 0]) ** 2
                error_1 = precisions[b, s, 1] * (means[b, s, 1] - brightness[f, 1]) ** 2
                tables[f, b, s] = max(constants[b, s] - 0.5 * (error_0 + error_1), -PENALTY_MAX)
    return tables


@lru_cache(maxsize=64)
def _likelihood_model(
    exposure: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return mean and inverse variance, shape (BINS, symbols, 2), and the constant of the log-likelihood."""
    levels = expected_levels(exposure, BINS, TIMING_SIGMA)
    means, variances = (np.ascontiguousarray(array.swapaxes(0, 1)) for array in levels)
    precisions = 1.0 / (variances + NOISE_SIGMA**2)
    return means, precisions, 0.5 * np.log(precisions * NOISE_SIGMA**2).sum(axis=2)
