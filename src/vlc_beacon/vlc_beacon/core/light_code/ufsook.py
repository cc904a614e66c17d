"""UFSOOK: undersampled frequency shift on-off keying, for global shutters at 60 frames a second (after Roberts 2013).

A symbol lasts two frames. In it the lamp blinks 8 times (*space*, 240 Hz, bit 0) or 7 times (*mark*, 210 Hz, bit 1): to
frames a sixtieth of a second apart, space looks steady and mark toggles. The marker is two symbols with 15 blinks
together (225 Hz): to the frames it advances a quarter of a cycle each, which no data does. The second half of the
panel runs a quarter of a cycle ahead: where the camera catches the edges of one
half, it catches the middle of the other.

Nothing blinks slowly: all symbols begin and end an eighth of a cycle into the first half, about which both halves
together are symmetric, so neither the mean nor the first moment of the light depends on the symbol.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from light_waveform import Waveform, waveform_of_steps
from vlc_beacon.core.light_code.symbol_code import SymbolCode

SPACE, MARK, MARKER_BEGIN, MARKER_END = range(4)
FRAME_RATE = 60.0
"""Of the camera [1/s]."""
UFSOOK = SymbolCode(bits=1, marker=(MARKER_BEGIN, MARKER_END), duration=2.0 / FRAME_RATE)
EIGHTHS = (64, 56, 60, 60)
"""Eighths of a cycle in each symbol: eight, seven and seven and a half blinks."""
FIRST_EIGHTH = (1, 1, 1, 5)
"""The eighth of a cycle that each symbol begins with."""
HALVES = np.repeat([[1.0, 1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0]], 2, axis=0)
"""Levels of both halves in each eighth of a cycle, shape (8, 2)."""


def ufsook_waveform(packets: list[bytes], clock_scale: float = 1.0) -> Waveform:
    """Return the waveform that plays packets one after the other, again and again.

    Args:
        packets: at least one.
        clock_scale: duration over nominal duration of everything, to simulate an inexact clock.
    """
    symbols = np.concatenate([UFSOOK.symbols_of(packet) for packet in packets])
    return waveform_of_symbols(symbols, clock_scale)


def waveform_of_symbols(symbols: NDArray[np.int64], clock_scale: float = 1.0) -> Waveform:
    """Return the waveform of symbols, shape (n,), with two parts."""
    eighths = [FIRST_EIGHTH[s] + np.arange(EIGHTHS[s]) for s in symbols]
    durations = [np.full(EIGHTHS[s], UFSOOK.duration / EIGHTHS[s] * clock_scale) for s in symbols]
    return waveform_of_steps(np.concatenate(durations), HALVES[np.concatenate(eighths) % 8])


def expected_levels(
    exposure: float, bins: int, timing_sigma: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what a frame sees of each symbol when its time is not quite certain.

    Args:
        exposure: of the frame [s].
        bins: places within a symbol, evenly spaced, at whose middles exposure begins.
        timing_sigma: standard deviation of that time [s].

    Returns:
        Mean and variance of the brightness, each of shape (4 symbols, bins, 2 halves).
    """
    starts = (np.arange(bins) + 0.5) / bins * UFSOOK.duration
    around = np.linspace(-2.5, 2.5, 21)
    weights = np.exp(-0.5 * around**2) / np.exp(-0.5 * around**2).sum()
    levels = []
    for symbol in range(4):
        # Exposures that run out of the symbol go on as the symbol would, which is as good a guess as any.
        eighth = UFSOOK.duration / EIGHTHS[symbol]
        blinks = waveform_of_steps(np.full(8, eighth), HALVES)
        shift = FIRST_EIGHTH[symbol] * eighth
        levels.append(blinks.exposed(starts[:, None] + shift + around * timing_sigma, exposure))
    seen = np.stack(levels)
    means = np.einsum('sbwh,w->sbh', seen, weights)
    return means, np.einsum('sbwh,w->sbh', seen**2, weights) - means**2
