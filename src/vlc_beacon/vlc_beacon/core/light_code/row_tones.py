"""Likelihood of the tones of a lamp, from its rows.

A square wave of frequency f appears as alternating bright and dark rows, blurred by the exposure. For each candidate
tone, the blurred square wave is fitted with the best phase, gain and offset; the residual gives the likelihood. One
cycle in view suffices, which a spectrum would not resolve.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import waveform_from_steps
from vlc_beacon.core.light_code.lamp_rows import LampRows

PHASES = 48
ROWS_MIN = 5
"""Minimum number of rows."""
RESIDUAL_FLOOR = 0.02
"""Minimum residual as a fraction of the variance, because lamps are not uniform."""
LOG_LIKELIHOOD_MIN = -40.0
"""Lower bound of the log-likelihood of one frame, relative to the best tone."""


def tone_log_likelihoods(rows: LampRows, tones: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the log-likelihood of each tone relative to the best one, shape (frames, n), 0 for the best.

    All are 0 if the rows are uniform or too few.

    Args:
        rows: row samples of the frames.
        tones: candidate tones, shape (n,) [Hz].
    """
    frames, count = rows.brightness.shape
    seen = rows.brightness - rows.brightness.mean(axis=1, keepdims=True)
    powers = (seen**2).sum(axis=1)
    if count < ROWS_MIN:
        return np.zeros((frames, len(tones)))
    templates = _tone_templates(count, rows.row_time, round(rows.exposure, 6), tones)
    fits = (
        np.maximum(seen @ templates.reshape(-1, count).T, 0.0).reshape(frames, len(tones), PHASES).max(axis=2)
    )
    explained = fits**2 / np.where(powers > 0.0, powers, np.inf)[:, None]
    # The noise is unknown; its maximum likelihood estimate for each tone is the residual.
    likelihoods = -0.5 * (count - 3) * np.log(1.0 - explained + RESIDUAL_FLOOR)
    return np.maximum(likelihoods - likelihoods.max(axis=1, keepdims=True), LOG_LIKELIHOOD_MIN)


@lru_cache(maxsize=32)
def _tone_templates(
    rows: int, row_time: float, exposure: float, tones: tuple[float, ...]
) -> NDArray[np.float32]:
    """Return zero-mean unit-norm templates of each tone in each phase, shape (n, PHASES, rows)."""
    templates = []
    for tone in tones:
        blinks = waveform_from_steps([0.5 / tone, 0.5 / tone], [1.0, 0.0])
        starts = np.arange(rows) * row_time + np.arange(PHASES)[:, None] / PHASES / tone
        templates.append(blinks.exposure_means(starts, exposure)[..., 0])
    seen = np.stack(templates)
    seen -= seen.mean(axis=2, keepdims=True)
    lengths = np.linalg.norm(seen, axis=2, keepdims=True)
    # Templates that are almost constant are disabled.
    visible = lengths > 1e-3 * np.sqrt(rows)
    return np.where(visible, seen / np.maximum(lengths, 1e-12), 0.0).astype(np.float32)
