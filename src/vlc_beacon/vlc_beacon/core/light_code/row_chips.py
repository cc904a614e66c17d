"""Rows of a lamp to the bits of the slot that it shows."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from vlc_beacon.core.light_code.lamp_rows import LampRows
from vlc_beacon.core.light_code.manchester import PREAMBLE, SlotFormat

PHASES = 10
"""Places within a chip that are tried for the beginning of the first row."""
SWING_MIN = 0.25
"""The weakest bit over the mean of all, below which a frame is not trusted."""


def bits_of_rows(rows: LampRows, slot_format: SlotFormat) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return the bits of the slot in view of each frame, and which frames show enough rows and clear bits.

    Chips are laid over the rows in every phase, wrapped around after one slot, and the slot's beginning is tried at
    every chip: preamble and bits together swing most where both are right.

    Returns:
        Shapes (n, bits) and (n,).
    """
    swings, preambles = _best_swings(
        rows.brightness,
        rows.row_time / slot_format.chip_time,
        rows.exposure / slot_format.chip_time,
        slot_format.chips,
    )
    sizes = np.abs(swings)
    weakest = np.minimum(sizes.min(axis=1), preambles / 3.0)
    typical = sizes.mean(axis=1)
    return (swings > 0.0).astype(np.uint8), (typical > 0.0) & (weakest >= SWING_MIN * typical)


@njit(cache=True)
def _best_swings(
    brightness: NDArray[np.float64], row_chips: float, exposure_chips: float, chips: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return each bit's first chip less its second, shape (n, bits), and the same of the preamble's halves, (n,).

    Zeros where the rows do not show all chips. Times are in chips.
    """
    frames, head = len(brightness), len(PREAMBLE)
    swings, preambles = np.zeros((frames, (chips - head) // 2)), np.zeros(frames)
    for f in range(frames):
        best = 0.0
        for phase in range(PHASES):
            levels = _chip_levels(brightness[f], phase / PHASES, row_chips, exposure_chips, chips)
            first, score, preamble = _best_beginning(levels)
            if score > best:
                best, preambles[f] = score, preamble
                for i in range(swings.shape[1]):
                    k = first + head + 2 * i
                    swings[f, i] = levels[k % chips] - levels[(k + 1) % chips]
    return swings, preambles


@njit(cache=True)
def _best_beginning(levels: NDArray[np.float64]) -> tuple[int, float, float]:
    """Return the chip at which the slot begins, its score and its preamble's swing; score 0 where chips lack."""
    chips, head = len(levels), len(PREAMBLE)
    sums = np.zeros(2)
    for k in range(chips):
        sums[k % 2] += abs(levels[k] - levels[(k + 1) % chips])
    best, best_score, best_preamble = 0, 0.0, 0.0
    for first in range(chips if np.isfinite(sums).all() else 0):
        # Chips are even in number: the bits' swings are all of one parity but those within the preamble.
        preamble, score = 0.0, sums[first % 2]
        for i in range(head):
            preamble += levels[(first + i) % chips] * (1.0 if PREAMBLE[i] else -1.0)
            if i % 2 == 0:
                score -= abs(levels[(first + i) % chips] - levels[(first + i + 1) % chips])
        if score + preamble > best_score:
            best, best_score, best_preamble = first, score + preamble, preamble
    return best, best_score, best_preamble


@njit(cache=True)
def _chip_levels(
    brightness: NDArray[np.float64], phase: float, row_chips: float, exposure_chips: float, chips: int
) -> NDArray[np.float64]:
    """Return the mean brightness of each chip of a slot, shape (chips,), NaN where no row shows it."""
    sums, weights = np.zeros(chips), np.zeros(chips)
    for row in range(len(brightness)):
        start = phase + row * row_chips
        chip = int(start + 0.5 * exposure_chips)
        # How much more of the exposure lies in this chip than in its neighbours.
        inside = min(start + exposure_chips, chip + 1.0) - max(start, float(chip))
        weight = max(2.0 * inside / exposure_chips - 1.0, 0.0)
        sums[chip % chips] += weight * brightness[row]
        weights[chip % chips] += weight
    return np.where(weights > 0.2, sums / np.maximum(weights, 1e-9), np.nan)
