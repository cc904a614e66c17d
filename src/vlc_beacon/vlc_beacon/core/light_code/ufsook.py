"""UFSOOK: undersampled frequency shift on-off keying, for global shutters at 60 frames/s (after Roberts 2013).

A symbol lasts two frames and holds 8 cycles (*space*, 240 Hz, bit 0) or 7 cycles (*mark*, 210 Hz, bit 1): sampled at
60 Hz, space is constant and mark toggles. The preamble is two symbols with 15 cycles in total (225 Hz): it advances by
a quarter of a cycle per frame, which no data does. The second half of the panel leads by a quarter of a cycle: when the
camera samples the edges of one half, it samples the middle of the other.

There is no low-frequency flicker: all symbols begin and end an eighth of a cycle into the first half, about which both
halves together are symmetric, so neither the mean nor the first moment of the light depends on the symbol.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform, waveform_from_steps
from vlc_beacon.core.light_code.symbol_code import SymbolCode

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
    """Return the periodic waveform of a sequence of packets.

    Args:
        packets: encoded packets, at least one.
        clock_scale: actual over nominal duration, to simulate a clock error.
    """
    symbols = np.concatenate([UFSOOK.encode_symbols(packet) for packet in packets])
    return waveform_from_symbols(symbols, clock_scale)


def waveform_from_symbols(symbols: NDArray[np.int64], clock_scale: float = 1.0) -> Waveform:
    """Return the waveform of symbols, shape (n,), with two parts."""
    eighths = [FIRST_EIGHTH[s] + np.arange(EIGHTHS[s]) for s in symbols]
    durations = [np.full(EIGHTHS[s], UFSOOK.duration / EIGHTHS[s] * clock_scale) for s in symbols]
    return waveform_from_steps(np.concatenate(durations), HALF_LEVELS[np.concatenate(eighths) % 8])


def expected_levels(
    exposure: float, bins: int, timing_sigma: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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
