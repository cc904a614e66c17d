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


def bits_of_rows(rows: LampRows, slot_format: SlotFormat) -> NDArray[np.uint8] | None:
    """Return the bits of the slot in view, or None where too few rows are there or a bit is not clear.

    Chips are laid over the rows in every phase, wrapped around after one slot, and the slot's beginning is tried at
    every chip: preamble and bits together swing most where both are right.
    """
    swings, preamble = _best_swings(
        rows.brightness.astype(np.float64),
        rows.row_time / slot_format.chip_time,
        rows.exposure / slot_format.chip_time,
        slot_format.chips,
    )
    typical = np.abs(swings).mean()
    if not typical > 0.0 or min(np.abs(swings).min(), preamble / 3.0) < SWING_MIN * typical:
        return None
    return (swings > 0.0).astype(np.uint8)


@njit(cache=True)
def _best_swings(
    brightness: NDArray[np.float64], row_chips: float, exposure_chips: float, chips: int
) -> tuple[NDArray[np.float64], float]:
    """Return each bit's first chip less its second, shape (bits,), and the same of the preamble's halves.

    Zeros where the rows do not show all chips. Times are in chips.
    """
    head = len(PREAMBLE)
    best, best_preamble, swings = 0.0, 0.0, np.zeros((chips - head) // 2)
    for phase in range(PHASES):
        levels = _chip_levels(brightness, phase / PHASES, row_chips, exposure_chips, chips)
        for first in range(chips if np.isfinite(levels).all() else 0):
            preamble = 0.0
            for k in range(head):
                preamble += levels[(first + k) % chips] * (1.0 if PREAMBLE[k] else -1.0)
            score = preamble
            for k in range(first + head, first + chips, 2):
                score += abs(levels[k % chips] - levels[(k + 1) % chips])
            if score > best:
                best, best_preamble = score, preamble
                for i in range(len(swings)):
                    k = first + head + 2 * i
                    swings[i] = levels[k % chips] - levels[(k + 1) % chips]
    return swings, best_preamble


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
