"""The pixels along the outline of a quadrilateral, and what they would show of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.edge_response import direction_bin, look_up


class Band(NamedTuple):
    """The n pixels along an outline.

    Attributes:
        values: shape (n,) [grey levels].
        covered: shape (n,), by how much the quadrilateral covers each, as it is seen.
        depths: shape (n,), how far inside of the nearest side [px].
        sides: shape (n,), the nearest one.
        places: shape (n, 3), from the middle along x and y, as parts of the size, and along the outline, 2 a side.
        changes: shape (n, 9), of the coverage by the corners' coordinates and the blur.
    """

    values: NDArray[np.float64]
    covered: NDArray[np.float64]
    depths: NDArray[np.float64]
    sides: NDArray[np.int64]
    places: NDArray[np.float64]
    changes: NDArray[np.float64]


@njit(cache=True, error_model='numpy')
def band_along(
    image: NDArray[np.uint8],
    corners: NDArray[np.float64],
    profiles: NDArray[np.float64],
    variance: float,
    reach: tuple[float, float],
) -> Band:
    """Return the pixels from so far outside (negative) to so far inside of the nearest side [px].

    The profiles are those of an edge of some variance [px²].
    """
    height, width = image.shape
    lines, bins = _lines(corners)
    left, right = max(0, int(np.min(corners[:, 0]) + reach[0])), int(np.max(corners[:, 0]) - reach[0]) + 1
    top, bottom = max(0, int(np.min(corners[:, 1]) + reach[0])), int(np.max(corners[:, 1]) - reach[0]) + 1
    right, bottom = min(right, width - 1), min(bottom, height - 1)
    room = min(
        (right - left + 1) * (bottom - top + 1), int(2.0 * (reach[1] - reach[0]) * np.sum(lines[:, 4]))
    )
    room = max(room, 0) + 64
    numbers = np.empty(room), np.empty(room), np.empty(room), np.empty(room, np.int64)
    band = Band(*numbers, np.empty((room, 3)), np.empty((room, 9)))
    middle, size = 0.25 * np.sum(corners, axis=0), 0.25 * np.sum(lines[:, 4])
    responses, distances = np.empty((4, 3)), np.empty(4)
    n = 0
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            nearest = 0
            for k in range(4):
                distances[k] = lines[k, 0] * x + lines[k, 1] * y - lines[k, 2]
                if distances[k] < distances[nearest]:
                    nearest = k
            depth = distances[nearest]
            if depth < reach[0] or depth > reach[1] or n == room:
                continue
            for k in range(4):
                look_up(profiles[bins[k]], distances[k], responses[k])
            band.values[n], band.depths[n], band.sides[n] = image[y, x], depth, nearest
            band.places[n, 0], band.places[n, 1] = (x - middle[0]) / size, (y - middle[1]) / size
            along = (lines[nearest, 1] * x - lines[nearest, 0] * y - lines[nearest, 3]) / lines[nearest, 4]
            band.places[n, 2] = 2.0 * (nearest + min(max(along, 0.0), 1.0))
            band.covered[n] = _write_changes(x, y, lines, responses, band.changes[n])
            band.covered[n] += _by_skew(lines, responses, variance)
            n += 1
    first = band.values[:n], band.covered[:n], band.depths[:n], band.sides[:n]
    return Band(*first, band.places[:n], band.changes[:n])


@njit(cache=True, error_model='numpy')
def _lines(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return normal to the inside, its offset, offset of the begin along the line, and length of each side, (4, 5).

    And the bins of their directions, shape (4,).
    """
    lines, bins = np.empty((4, 5)), np.empty(4, np.int64)
    for k in range(4):
        dx, dy = corners[(k + 1) % 4] - corners[k]
        length = np.sqrt(dx * dx + dy * dy)
        dx, dy = dx / length, dy / length
        lines[k, 0], lines[k, 1] = -dy, dx
        lines[k, 2] = -dy * corners[k, 0] + dx * corners[k, 1]
        lines[k, 3], lines[k, 4] = dx * corners[k, 0] + dy * corners[k, 1], length
        bins[k] = direction_bin(-dy, dx)
    return lines, bins


@njit(cache=True, error_model='numpy')
def _write_changes(
    x: float,
    y: float,
    lines: NDArray[np.float64],
    responses: NDArray[np.float64],
    changes: NDArray[np.float64],
) -> float:
    """Write how corners and blur change the coverage of a pixel, and return it."""
    covered = responses[0, 0] * responses[1, 0] * responses[2, 0] * responses[3, 0]
    changes[:] = 0.0
    for k in range(4):
        after = (k + 1) % 4
        others = responses[after, 0] * responses[(k + 2) % 4, 0] * responses[(k + 3) % 4, 0]
        slope = others * responses[k, 1]
        changes[8] += others * responses[k, 2]
        along = (lines[k, 1] * x - lines[k, 0] * y - lines[k, 3]) / lines[k, 4]
        for c in range(2):
            changes[2 * k + c] -= slope * (1.0 - along) * lines[k, c]
            changes[2 * after + c] -= slope * along * lines[k, c]
    return covered


@njit(cache=True, error_model='numpy')
def _by_skew(lines: NDArray[np.float64], responses: NDArray[np.float64], variance: float) -> float:
    """Return what the coverage is more than the product of the sides where these meet at no right angle.

    The coverage at a corner is the probability that two correlated normal deviates are both below their limits; this is
    the first term of its series by the correlation, which is that of the sides' normals.
    """
    more = 0.0
    for k in range(4):
        after = (k + 1) % 4
        correlation = lines[k, 0] * lines[after, 0] + lines[k, 1] * lines[after, 1]
        others = responses[(k + 2) % 4, 0] * responses[(k + 3) % 4, 0]
        more += correlation * variance * responses[k, 1] * responses[after, 1] * others
    return more
