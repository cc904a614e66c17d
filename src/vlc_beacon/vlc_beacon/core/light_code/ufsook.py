"""UFSOOK: undersampled frequency shift on-off keying, for global shutters at 60 frames/s (after Roberts 2013).

A symbol lasts two frames and holds 8 cycles (*space*, 240 Hz, bit 0) or 7 cycles (*mark*, 210 Hz, bit 1): sampled at
60 Hz, space is constant and mark toggles. The preamble is two symbols with 15 cycles in total (225 Hz): it advances by
a quarter of a cycle per frame, which no data does. The second half of the panel leads by a quarter of a cycle: when the
camera samples the edges of one half, it samples the middle of the other.

There is no low-frequency flicker: all symbols begin and end an eighth of a cycle into the first half, about which both
halves together are symmetric, so neither the mean nor the first moment of the light depends on the symbol.
"""

from functools import lru_cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shirube_core.waveform import Waveform, waveform_from_steps
from vlc_beacon.core.light_code.symbol_code import SymbolCode
from vlc_beacon.core.light_code.symbol_receiver import SymbolReceiver
from vlc_beacon.core.packet.packet_reader import ReceivedPacket

SPACE, MARK, PREAMBLE_FIRST, PREAMBLE_SECOND = range(4)
FRAME_RATE = 60.0
"""Frame rate of the camera [1/s]."""
UFSOOK = SymbolCode(bits=1, preamble=(PREAMBLE_FIRST, PREAMBLE_SECOND), duration=2.0 / FRAME_RATE)
EIGHTHS = (64, 56, 60, 60)
"""Eighths of a cycle in each symbol: 8, 7, 7.5 and 7.5 cycles."""
FIRST_EIGHTH = (1, 1, 1, 5)
"""Initial phase of each symbol in eighths of a cycle."""
HALF_LEVELS = np.repeat([[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]], 2, axis=0)
"""Levels of both halves in each eighth of a cycle, shape (8, 2)."""


def ufsook_waveform(packets: list[bytes], clock_scale: float = 1.0) -> Waveform:
    """Return the periodic waveform of encoded packets; ``clock_scale`` simulates a clock error."""
    symbols = np.concatenate([UFSOOK.encode_symbols(packet) for packet in packets])
    return waveform_from_symbols(symbols, clock_scale)


def waveform_from_symbols(symbols: NDArray[np.int64], clock_scale: float = 1.0) -> Waveform:
    """Return the waveform of symbols, shape (n,), with two parts."""
    eighths = [FIRST_EIGHTH[s] + np.arange(EIGHTHS[s]) for s in symbols]
    durations = [np.full(EIGHTHS[s], UFSOOK.duration / EIGHTHS[s] * clock_scale) for s in symbols]
    return waveform_from_steps(np.concatenate(durations), HALF_LEVELS[np.concatenate(eighths) % 8])


def expected_levels(exposure: float, bins: int, timing_sigma: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the expected brightness of each symbol in a frame with uncertain time.

    Args:
        exposure: exposure of the frame [s].
        bins: number of evenly spaced positions within a symbol, at whose centres the exposure starts.
        timing_sigma: standard deviation of the start of exposure [s].

    Returns:
        mean and variance of the brightness, each of shape (4 symbols, bins, 2 halves).
    """
    starts = (np.arange(bins) + 0.5) / bins * UFSOOK.duration
    offsets = np.linspace(-2.5, 2.5, 21)
    weights = np.exp(-0.5 * offsets**2) / np.exp(-0.5 * offsets**2).sum()
    levels = []
    for symbol in range(4):
        # Exposures that extend beyond the symbol are computed as if it continued.
        eighth = UFSOOK.duration / EIGHTHS[symbol]
        cycle = waveform_from_steps(np.full(8, eighth), HALF_LEVELS)
        shift = FIRST_EIGHTH[symbol] * eighth
        levels.append(cycle.exposure_means(starts[:, None] + shift + offsets * timing_sigma, exposure))
    seen = np.stack(levels)
    means = np.einsum('sbwh,w->sbh', seen, weights)
    return means, np.einsum('sbwh,w->sbh', seen**2, weights) - means**2


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
def _likelihood_model(exposure: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return mean and inverse variance, shape (BINS, symbols, 2), and the constant of the log-likelihood."""
    levels = expected_levels(exposure, BINS, TIMING_SIGMA)
    means, variances = (np.ascontiguousarray(array.swapaxes(0, 1)) for array in levels)
    precisions = 1.0 / (variances + NOISE_SIGMA**2)
    return means, precisions, 0.5 * np.log(precisions * NOISE_SIGMA**2).sum(axis=2)
