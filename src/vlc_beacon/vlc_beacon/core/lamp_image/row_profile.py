"""Brightness of a lamp row by row, as a rolling shutter samples its modulation.

A lamp is round: its radial profile is the same along the rows, which are not modulated, as along the columns. Each row
is the radial profile times the instantaneous light level; both are estimated alternately. Rows near the rim and in the
halo can then be used as well, and the end of the lamp is not mistaken for a dark band.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

HALO = (3.0, 24.0)
"""The halo of a bright lamp is modulated too. Rows are used up to this distance from the centre [lamp radii] and from
the rim [px]."""
COLUMNS = 20.0
"""Lamps with a larger radius [px] are sampled at a subset of their columns."""
RINGS = 2.0
"""Resolution of the radial profile [1/px]."""
WEIGHT_MIN = 1.0
"""Minimum weight of a ring, in bright pixels, to be estimated."""
ROUNDS = 3
SIGMA_MAX = 0.15
"""Maximum standard deviation of a row's brightness [fraction of full light]; other rows are rejected."""
LEVELS_MIN = 3.0
"""Minimum brightness of the lamp above its background in a row [grey levels]."""
SHARE_MIN = 0.05
"""Minimum full brightness of a row as a fraction of the brightest row."""


def row_profile(
    image: NDArray[np.uint8],
    centre: NDArray[np.float64],
    radius: float,
    background: float,
    noise: float = 1.0,
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
    reach = min(HALO[0] * radius, radius + HALO[1])
    (left, top), (right, bottom) = np.ceil(centre - reach), np.floor(centre + reach) + 1
    left, top, right, bottom = max(left, 0), max(top, 0), min(right, width), min(bottom, height)
    if left >= right or top >= bottom:
        return int(top), np.empty(0)
    window = image[int(top) : int(bottom), int(left) : int(right)]
    step = 1 + int(radius / COLUMNS)
    shares, peaks, powers = _shares_of_rows(
        window, centre[0] - left, centre[1] - top, reach, background, step
    )
    least = max(LEVELS_MIN, SHARE_MIN * peaks.max())
    shown = (peaks >= least) & (powers >= (noise / SIGMA_MAX) ** 2)
    middle = min(max(round(float(centre[1] - top)), 0), len(shares) - 1)
    if not shown[middle]:
        return int(top) + middle, np.empty(0)
    hidden = np.flatnonzero(~shown)
    begin = int(hidden[hidden < middle].max(initial=-1)) + 1
    end = int(hidden[hidden > middle].min(initial=len(shares)))
    return int(top) + begin, shares[begin:end]


@njit(cache=True)
def _shares_of_rows(
    window: NDArray[np.uint8], u: float, v: float, reach: float, background: float, step: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the fraction of full light of each row, and the peak [grey levels] and the sum of squares of the full
    lamp in it, all of shape (h,).

    Args:
        window: image around the lamp, shape (h, w).
        u: column of the centre [px].
        v: row of the centre [px].
        reach: maximum distance from the centre [px].
        background: brightness of the background [grey levels].
        step: distance between sampled columns [px].
    """
    profile = _first_profile(window, u, v, reach, background, step)
    rows = len(window)
    shares, peaks, powers = np.zeros(rows), np.zeros(rows), np.zeros(rows)
    for _ in range(ROUNDS):
        _fit_rows(window, u, v, background, step, profile, shares, peaks, powers)
        if not shares.max() > 0.0:
            break
        shares /= shares.max()
        _fit_profile(window, u, v, background, step, profile, shares)
    return shares, peaks, powers


@njit(cache=True)
def _fit_rows(
    window: NDArray[np.uint8],
    u: float,
    v: float,
    background: float,
    step: int,
    profile: NDArray[np.float64],
    shares: NDArray[np.float64],
    peaks: NDArray[np.float64],
    powers: NDArray[np.float64],
) -> None:
    """Set the outputs of `_shares_of_rows` for a known profile."""
    for row in range(len(window)):
        light, powers[row], peaks[row] = 0.0, 0.0, 0.0
        for column in range(0, window.shape[1], step):
            place = RINGS * math.hypot(column - u, row - v)
            ring = int(place)
            if ring + 1 < len(profile):
                full = profile[ring] + (place - ring) * (profile[ring + 1] - profile[ring])
                light += full * (window[row, column] - background)
                powers[row] += full**2
                peaks[row] = max(peaks[row], full)
        shares[row] = light / powers[row] if peaks[row] >= LEVELS_MIN else 0.0


@njit(cache=True)
def _fit_profile(
    window: NDArray[np.uint8],
    u: float,
    v: float,
    background: float,
    step: int,
    profile: NDArray[np.float64],
    shares: NDArray[np.float64],
) -> None:
    """Fit the profile to known rows; dark rings keep their values."""
    light, weights = np.zeros(len(profile)), np.zeros(len(profile))
    for row in range(len(window)):
        if shares[row] > 0.0:
            for column in range(0, window.shape[1], step):
                place = RINGS * math.hypot(column - u, row - v)
                ring = int(place)
                if ring + 1 < len(profile):
                    for side in (0, 1):
                        weight = abs(1 - side - (place - ring)) * shares[row]
                        light[ring + side] += weight * (window[row, column] - background)
                        weights[ring + side] += weight * shares[row]
    for ring in range(len(profile)):
        if weights[ring] > WEIGHT_MIN:
            profile[ring] = light[ring] / weights[ring]
    _fall_outwards(profile)


@njit(cache=True)
def _first_profile(
    window: NDArray[np.uint8], u: float, v: float, reach: float, background: float, step: int
) -> NDArray[np.float64]:
    """Return the maximum of each ring around the centre, shape (rings,) [grey levels]."""
    profile = np.zeros(int(RINGS * reach) + 2)
    for row in range(len(window)):
        for column in range(0, window.shape[1], step):
            ring = int(RINGS * math.hypot(column - u, row - v) + 0.5)
            if ring < len(profile):
                profile[ring] = max(profile[ring], window[row, column] - background)
    _fall_outwards(profile)
    return profile


@njit(cache=True)
def _fall_outwards(profile: NDArray[np.float64]) -> None:
    """Make the profile monotonically decreasing outwards; a darker ring is in a dark band."""
    for ring in range(len(profile) - 2, -1, -1):
        profile[ring] = max(profile[ring], profile[ring + 1])
