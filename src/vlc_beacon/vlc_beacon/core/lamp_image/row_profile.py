"""Brightness of a lamp row by row, as a rolling shutter samples its modulation.

A lamp is round: its radial profile is the same along the rows, which are not modulated, as along the columns. Each row
is the radial profile times the instantaneous light level; both are estimated alternately. Rows near the rim and in the
halo can then be used as well, and the end of the lamp is not mistaken for a dark band.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class LampRows:
    """Row brightness of a lamp in frames in which it covers the same number of rows; usually one frame.

    Attributes:
        stamps: start of exposure of image row 0, shape (n,) [s].
        first_rows: first row of the lamp in each image, shape (n,).
        brightness: mean of each row over the lamp, shape (n, rows), any unit.
        row_time: line time between the starts of two rows [s].
        exposure: exposure of a row [s].
    """

    stamps: NDArray[np.float64]
    first_rows: NDArray[np.int64]
    brightness: NDArray[np.float64]
    row_time: float
    exposure: float

    @property
    def centre_times(self) -> NDArray[np.float64]:
        """Times at which the middle of the lamp was exposed, shape (n,) [s]."""
        rows = self.first_rows + 0.5 * (self.brightness.shape[1] - 1)
        return self.stamps + rows * self.row_time + 0.5 * self.exposure

    def drop_invalid_frames(self) -> LampRows:
        """Return the frames in which all rows are finite."""
        kept = np.isfinite(self.brightness).all(axis=1)
        if kept.all():
            return self
        return LampRows(self.stamps[kept], self.first_rows[kept], self.brightness[kept], self.row_time, self.exposure)


def rows_from_frame(stamp: float, first_row: int, brightness: ArrayLike, row_time: float, exposure: float) -> LampRows:
    """Return the rows of a lamp in one frame; brightness has shape (rows,), other arguments as in `LampRows`."""
    seen = np.asarray(brightness, float)[None]
    return LampRows(np.array([stamp]), np.array([first_row]), seen, row_time, exposure)


HALO_LIMITS = (3.0, 24.0)
"""The halo of a bright lamp is modulated too. Rows are used up to this distance from the centre [lamp radii] and from
the rim [px]."""
DENSE_RADIUS = 20.0
"""Lamps with a larger radius [px] are sampled at a subset of their columns."""
RINGS_PER_PIXEL = 2.0
"""Resolution of the radial profile [1/px]."""
WEIGHT_MIN = 1.0
"""Minimum weight of a ring, in bright pixels, to be estimated."""
ITERATIONS = 3
SIGMA_MAX = 0.15
"""Maximum standard deviation of a row's brightness [fraction of full light]; other rows are rejected."""
LEVELS_MIN = 3.0
"""Minimum brightness of the lamp above its background in a row [grey levels]."""
FRACTION_MIN = 0.05
"""Minimum full brightness of a row as a fraction of the brightest row."""


def row_profile(
    image: NDArray[np.uint8], centre: NDArray[np.float64], radius: float, background: float, noise: float = 1.0
) -> tuple[int, NDArray[np.float64]]:
    """Return the first row and the brightness of the rows relative to full light, shape (m,), about 0 to 1.

    Args:
        image: grey image, shape (h, w).
        centre: centre of the lamp, shape (2,) [px].
        radius: lamp radius [px].
        background: brightness of the background [grey levels].
        noise: standard deviation of a pixel [grey levels].
    """
    height, width = image.shape
    extent = min(HALO_LIMITS[0] * radius, radius + HALO_LIMITS[1])
    (left, top), (right, bottom) = np.ceil(centre - extent), np.floor(centre + extent) + 1
    left, top, right, bottom = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    if left >= right or top >= bottom:
        return int(top), np.empty(0)
    window = image[int(top) : int(bottom), int(left) : int(right)]
    step = 1 + int(radius / DENSE_RADIUS)
    fractions, peaks, powers = _row_fractions(window, centre[0] - left, centre[1] - top, extent, background, step)
    threshold = max(LEVELS_MIN, FRACTION_MIN * peaks.max())
    visible = (peaks >= threshold) & (powers >= (noise / SIGMA_MAX) ** 2)
    middle = min(max(round(float(centre[1] - top)), 0), len(fractions) - 1)
    if not visible[middle]:
        return int(top) + middle, np.empty(0)
    hidden = np.flatnonzero(~visible)
    begin = int(hidden[hidden < middle].max(initial=-1)) + 1
    end = int(hidden[hidden > middle].min(initial=len(fractions)))
    return int(top) + begin, fractions[begin:end]


def _row_fractions(
    window: NDArray[np.uint8], u: float, v: float, extent: float, background: float, step: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the fraction of full light of each row, and the peak [grey levels] and the sum of squares of the full
    lamp in it, all of shape (h,).

    Args:
        window: image around the lamp, shape (h, w).
        u: column of the centre [px].
        v: row of the centre [px].
        extent: maximum distance from the centre [px].
        background: brightness of the background [grey levels].
        step: distance between sampled columns [px].
    """
    levels = window[:, ::step] - background
    columns, rows = np.arange(0, window.shape[1], step) - u, np.arange(len(window)) - v
    positions = RINGS_PER_PIXEL * np.hypot(columns, rows[:, None])
    count = int(RINGS_PER_PIXEL * extent) + 2
    rings = np.minimum(positions.astype(np.int64), count - 2)
    # Shares of the inner and the outer ring next to each pixel; none beyond the profile.
    inside = positions < count - 1
    shares = np.where(inside, 1.0 - positions + rings, 0.0), np.where(inside, positions - rings, 0.0)
    # A darker ring is in a dark band: the profile decreases outwards.
    profile = np.zeros(count)
    nearest = (positions + 0.5).astype(np.int64)
    np.maximum.at(profile, nearest[nearest < count], levels[nearest < count])
    for _ in range(ITERATIONS):
        profile = np.maximum.accumulate(profile[::-1])[::-1]
        # Rows for a known profile.
        full = shares[0] * profile[rings] + shares[1] * profile[rings + 1]
        peaks, powers = full.max(axis=1), (full**2).sum(axis=1)
        fractions = np.where(peaks >= LEVELS_MIN, (full * levels).sum(axis=1) / np.maximum(powers, 1e-9), 0.0)
        if not fractions.max() > 0.0:
            break
        fractions /= fractions.max()
        # Profile for known rows; dark rings keep their values.
        lit = np.maximum(fractions, 0.0)[:, None]
        light, weights = np.zeros(count), np.zeros(count)
        for side, share in enumerate(shares):
            numbers, weight = (rings + side).ravel(), share * lit
            light += np.bincount(numbers, (weight * levels).ravel(), count)
            weights += np.bincount(numbers, (weight * lit).ravel(), count)
        profile = np.where(weights > WEIGHT_MIN, light / np.maximum(weights, WEIGHT_MIN), profile)
    return fractions, peaks, powers
