"""Which tone a lamp plays, from its rows.

A lamp that blinks at f shows rows that are bright and dark in turn, smeared by the exposure. For each tone that may be,
the smeared square wave with the best phase, gain and offset is laid on the rows; what it leaves unexplained tells its
likelihood. A cycle in view suffices, which a spectrum would not resolve.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from light_waveform import waveform_of_steps
from vlc_beacon.core.light_code.lamp_rows import LampRows

PHASES = 48
ROWS_MIN = 5
"""Fewer rows tell nothing."""
RESIDUAL_FLOOR = 0.02
"""Share of the rows' variance that is never explained: lamps are not evenly bright."""
LIKELIHOOD_MIN = -40.0
"""Log likelihood below the best tone's that one frame may give at most."""


def tone_likelihoods(rows: LampRows, tones: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the log likelihood of each tone relative to the best one, shape (frames, n), 0 for the best.

    All are 0 where the rows are even or too few to tell.

    Args:
        rows: of the frames.
        tones: shape (n,) [Hz].
    """
    frames, count = rows.brightness.shape
    seen = rows.brightness - rows.brightness.mean(axis=1, keepdims=True)
    powers = (seen**2).sum(axis=1)
    if count < ROWS_MIN:
        return np.zeros((frames, len(tones)))
    shapes = _tone_shapes(count, rows.row_time, round(rows.exposure, 6), tones)
    fits = np.maximum(seen @ shapes.reshape(-1, count).T, 0.0).reshape(frames, len(tones), PHASES).max(axis=2)
    explained = fits**2 / np.where(powers > 0.0, powers, np.inf)[:, None]
    # The noise is not known; its best estimate for each tone is what that tone leaves.
    likelihoods = -0.5 * (count - 3) * np.log(1.0 - explained + RESIDUAL_FLOOR)
    return np.maximum(likelihoods - likelihoods.max(axis=1, keepdims=True), LIKELIHOOD_MIN)


@lru_cache(maxsize=32)
def _tone_shapes(
    rows: int, row_time: float, exposure: float, tones: tuple[float, ...]
) -> NDArray[np.float32]:
    """Return the rows of each tone in each phase, without mean, of length 1; shape (n, PHASES, rows)."""
    shapes = []
    for tone in tones:
        blinks = waveform_of_steps([0.5 / tone, 0.5 / tone], [1.0, 0.0])
        starts = np.arange(rows) * row_time + np.arange(PHASES)[:, None] / PHASES / tone
        shapes.append(blinks.exposed(starts, exposure)[..., 0])
    seen = np.stack(shapes)
    seen -= seen.mean(axis=2, keepdims=True)
    lengths = np.linalg.norm(seen, axis=2, keepdims=True)
    # A phase in which the rows look even explains nothing.
    shown = lengths > 1e-3 * np.sqrt(rows)
    return np.where(shown, seen / np.maximum(lengths, 1e-12), 0.0).astype(np.float32)
