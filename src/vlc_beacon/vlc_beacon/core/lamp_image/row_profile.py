"""Brightness of a lamp row by row, as a rolling shutter sees it blink.

A lamp is round: how its light falls off outwards is the same along the rows, which do not blink, as along the columns.
So each row is the lamp's own profile times what the lamp shone then, and both follow from each other. Rows near the rim
and in the halo are then as good as others, and where the lamp ends is no dark stripe.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

HALO = (3.0, 24.0)
"""The halo of a bright lamp blinks too. Rows are taken as far as it shows, at most to so many radii from the centre and
so many pixels beyond the rim."""
COLUMNS = 20.0
"""A lamp of so many radii in pixels has columns to spare: of larger ones only some are looked at."""
RINGS = 2.0
"""Points of the profile [1/px]."""
WEIGHT_MIN = 1.0
"""Rings that are seen in fewer bright pixels tell nothing."""
ROUNDS = 3
SIGMA_MAX = 0.15
"""Rows whose brightness is less certain are left out [shares of full light]."""
LEVELS_MIN = 3.0
"""And those where the lamp is less bright over its background [grey levels]: this is not known so well."""
SHARE_MIN = 0.05
"""And those that are less bright in full light than this share of the brightest: on a steep rim little is known."""


def row_profile(
    image: NDArray[np.uint8],
    centre: NDArray[np.float64],
    radius: float,
    background: float,
    noise: float = 1.0,
) -> tuple[int, NDArray[np.float64]]:
    """Return the first row and the brightness of the rows over the lamp's full one, shape (m,), about 0 to 1.

    Args:
        image: shape (h, w).
        centre: shape (2,) [px].
        radius: of the lamp [px].
        background: around the lamp [grey levels].
        noise: of a pixel [grey levels].
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
    """Return what share of full light each row shows, and the peak [grey levels] and the sum of squares of the full
    lamp in it, all of shape (h,).

    Args:
        window: shape (h, w), the lamp and what is around it.
        u: column of the centre.
        v: its row.
        reach: light from farther away is not the lamp's [px].
        background: around the lamp [grey levels].
        step: between the columns that are looked at [px].
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
    """Fill in what `_shares_of_rows` returns, of a known profile."""
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
    """Fit the profile to known rows; rings that are dark stay as they are."""
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
    """Return the brightest of each ring around the centre, shape (rings,) [grey levels]."""
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
    """Let no ring be darker than those around it: it is in a dark stripe."""
    for ring in range(len(profile) - 2, -1, -1):
        profile[ring] = max(profile[ring], profile[ring + 1])
