"""Optical channel from waveform to camera samples: exposure, clock offset, jitter, noise, lost frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shirube_core.waveform import Waveform
from vlc_beacon.core.lamp_image.row_profile import LampRows


def seen_by_global_shutter(
    waveform: Waveform,
    seconds: float,
    rng: np.random.Generator,
    *,
    exposure: float = 5e-4,
    snr: float = 15.0,
    jitter: float = 5e-5,
    lost: float = 0.0,
    frame_rate: float = 60.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return stamps (n,) and the brightness of both halves (n, 2)."""
    stamps = rng.uniform(0.0, 1000.0) + np.arange(round(seconds * frame_rate)) / frame_rate
    stamps = stamps[rng.random(len(stamps)) >= lost]
    seen = waveform.exposure_means(stamps + rng.normal(0.0, jitter, len(stamps)), exposure)
    return stamps, seen + rng.normal(0.0, 1.0 / snr, seen.shape)


def seen_by_rolling_shutter(
    waveform: Waveform,
    seconds: float,
    rng: np.random.Generator,
    *,
    rows: int = 16,
    row_time: float = 18.9e-6,
    exposure: float = 6e-5,
    snr: float = 15.0,
    jitter: float = 5e-5,
    lost: float = 0.0,
    frame_rate: float = 30.0,
) -> LampRows:
    """Return the rows of all frames."""
    stamps = rng.uniform(0.0, 1000.0) + np.arange(round(seconds * frame_rate)) / frame_rate
    stamps = stamps[rng.random(len(stamps)) >= lost]
    starts = (stamps + rng.normal(0.0, jitter, len(stamps)))[:, None] + np.arange(rows) * row_time
    seen = waveform.exposure_means(starts, exposure)[..., 0]
    seen += rng.normal(0.0, 1.0 / snr, seen.shape)
    return LampRows(stamps, np.zeros(len(stamps), np.int64), seen, row_time, exposure)
