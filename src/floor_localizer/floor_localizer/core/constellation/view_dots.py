"""The dots of one view, prepared for the search."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Complexes, Floats, Ints

# Expected number of dots in the first search circle, as a multiple of the wanted number; fewer near the border.
_OVERSAMPLING = 1.5
# Number of neighbours per dot: enough for the longest baseline of a constellation and for the pair search.
_MAX_NEIGHBOURS = 32


@njit(cache=True)
def sort_neighbours(points: Floats, limit: int) -> Ints:
    """Return the indices of up to ``limit`` neighbours of each dot, shape (n, 2), nearest first, shape (n, m)."""
    n = len(points)
    m = max(min(n - 1, limit), 0)
    nearest = np.empty((n, m), dtype=np.int64)
    if m == 0:
        return nearest
    # Sorted along x, the candidates for a circle are contiguous.
    order = np.argsort(points[:, 0])
    x, y = points[order, 0], points[order, 1]
    squared, near = np.empty(n), np.empty(n, dtype=np.int64)
    squared_radius = max(_area(points) * _OVERSAMPLING * m / (math.pi * n), 1e-12)
    for i in range(n):
        squared_limit = squared_radius
        count = _sort_within(x, y, i, squared_limit, squared, near)
        while count < m:
            squared_limit *= 3.0
            count = _sort_within(x, y, i, squared_limit, squared, near)
        for k in range(m):
            nearest[order[i], k] = order[near[k]]
    return nearest


@njit(cache=True)
def _area(points: Floats) -> float:
    """Return the area of the bounding box of points, shape (n, 2)."""
    x, y = points[:, 0], points[:, 1]
    return float((np.max(x) - np.min(x)) * (np.max(y) - np.min(y)))


@njit(cache=True)
def _sort_within(x: Floats, y: Floats, i: int, limit: float, squared: Floats, near: Ints) -> int:
    """Write the indices of the dots up to a squared distance from dot i to ``near``, sorted; return their number.

    The dots are sorted by x; ``squared`` is a buffer for their squared distances.
    """
    radius = math.sqrt(limit)
    count = 0
    for j in range(np.searchsorted(x, x[i] - radius), np.searchsorted(x, x[i] + radius, 'right')):
        squared[j] = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2
        if j != i and squared[j] <= limit:
            k = count
            while k > 0 and squared[near[k - 1]] > squared[j]:
                near[k] = near[k - 1]
                k -= 1
            near[k] = j
            count += 1
    return count


class ViewDots(NamedTuple):
    """The dots of one view, prepared for the search.

    Attributes:
        points: shape (n, 2), dots on the floor in the base frame, for the camera as mounted [m].
        z: shape (n,) complex, the same points.
        neighbours: shape (n, m), neighbours of each dot, nearest first.
        sigma: standard deviation of a dot's position along each axis, of image and map together [m].
        tilt_distortion: shift of a dot by tilt over its squared distance from the dots fitted so far [1/m].
        scale_tolerance: maximum relative error of the camera's height.
        density: density of the map's dots on the occupied floor [1/m^2].
    """

    points: Floats
    z: Complexes
    neighbours: Ints
    sigma: float
    tilt_distortion: float
    scale_tolerance: float
    density: float


def make_view(
    points: Floats, sigma: float, tilt_distortion: float, scale_tolerance: float, density: float
) -> ViewDots:
    """Return the view of dots on the floor at ``points``, shape (n, 2) [m]; other arguments as in `ViewDots`."""
    z = points[:, 0] + 1j * points[:, 1]
    return ViewDots(
        points, z, sort_neighbours(points, _MAX_NEIGHBOURS), sigma, tilt_distortion, scale_tolerance, density
    )


def mirror_view(view: ViewDots) -> ViewDots:
    """Return the mirror image of a view, left and right swapped."""
    return view._replace(points=view.points * (1.0, -1.0), z=view.z.conj())
