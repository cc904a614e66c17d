"""The dots of one image: detected, on the floor, prepared for the search; and of the map (paper 2.1) with its levels.

The levels are the floors of a building, side by side in one map frame, so that one index covers them all.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Complexes, Floats, Ints
from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2

# Maximum distance between two observations of the same dot [standard deviations].
_SAME_DOT_SIGMAS = 4.0
# Expected number of dots in the first search circle, as a multiple of the wanted number; fewer near the border.
_OVERSAMPLING = 1.5
# Number of neighbours per dot: enough for the longest baseline of a constellation and for the pair search.
_MAX_NEIGHBOURS = 32
# Gap between levels, larger than any constellation [m].
_GAP = 2.0
# Largest extent of the map; single precision resolves 0.03 mm there [m].
_MAX_EXTENT = 1024.0


@dataclass(frozen=True)
class DetectedDots:
    """Dots detected in one image, in coordinates of the raw (distorted) image.

    Attributes:
        pixels: shape (n, 2), centroids u and v [px]; the origin is the centre of the upper left pixel.
        diameters: shape (n,), diameters of discs of equal area [px].
        sigmas: shape (n,), standard deviations of the centroids along each axis [px].
    """

    pixels: Floats
    diameters: Floats
    sigmas: Floats

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.pixels)


@dataclass(frozen=True)
class FloorPoints:
    """Dots on the floor: ``points`` in the base frame, (n, 2) [m], ``sigmas`` along each axis, (n,) [m]."""

    points: Floats
    sigmas: Floats


def transform_points(points: FloorPoints, T_new_old: SE2, odometry_error: float) -> FloorPoints:
    """Transform points to the base frame at a later time, in which the old one is ``T_new_old`` by odometry.

    ``odometry_error`` is a fraction of the distance driven.
    """
    distance = math.hypot(T_new_old.x, T_new_old.y)
    return FloorPoints(T_new_old.transform(points.points), np.hypot(points.sigmas, odometry_error * distance / 3.0))


def merge_points(first: FloorPoints, second: FloorPoints) -> FloorPoints:
    """Return the union of two sets of points; points of the first that also are in the second are dropped."""
    if len(first.points) == 0 or len(second.points) == 0:
        return second if len(first.points) == 0 else first
    distances, nearest = cKDTree(second.points).query(first.points)
    is_new = distances > _SAME_DOT_SIGMAS * np.hypot(first.sigmas, second.sigmas[nearest])
    return FloorPoints(
        np.vstack([second.points, first.points[is_new]]), np.concatenate([second.sigmas, first.sigmas[is_new]])
    )


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


def make_view(points: Floats, sigma: float, tilt_distortion: float, scale_tolerance: float, density: float) -> ViewDots:
    """Return the view of dots on the floor at ``points``, shape (n, 2) [m]; other arguments as in `ViewDots`."""
    z = points[:, 0] + 1j * points[:, 1]
    return ViewDots(
        points, z, sort_neighbours(points, _MAX_NEIGHBOURS), sigma, tilt_distortion, scale_tolerance, density
    )


def mirror_view(view: ViewDots) -> ViewDots:
    """Return the mirror image of a view, left and right swapped."""
    return view._replace(points=view.points * (1.0, -1.0), z=view.z.conj())


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


@dataclass(frozen=True)
class DotMap:
    """All dots of a floor: centres in the map frame, (N, 2) [m], diameters of discs of equal area, (N,) [m] or NaN."""

    points: Floats
    diameters: Floats

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.points)


@dataclass(frozen=True)
class Level:
    """One level (floor) of the map.

    Attributes:
        name: name of the level.
        offset: x and y of the level's origin in the map frame [m].
        lower: lower left corner of its dots in the map frame [m].
        upper: upper right corner [m].
    """

    name: str
    offset: tuple[float, float]
    lower: tuple[float, float]
    upper: tuple[float, float]

    def to_map(self, T_level_base: SE2) -> SE2:
        """Transform a pose from the level frame to the map frame."""
        return SE2(T_level_base.x + self.offset[0], T_level_base.y + self.offset[1], T_level_base.yaw)

    def to_level(self, T_map_base: SE2) -> SE2:
        """Transform a pose from the map frame to the level frame; the inverse of `to_map`."""
        return SE2(T_map_base.x - self.offset[0], T_map_base.y - self.offset[1], T_map_base.yaw)


def arrange_levels(names: Sequence[str], corners: Sequence[tuple[float, float, float, float]]) -> tuple[Level, ...]:
    """Arrange levels side by side in rows that form about a square.

    ``corners`` are the bounding box (x min, y min, x max, y max) of the dots of each level in its own frame [m].

    Raises:
        FloorLocalizerError: the levels together are larger than single precision allows.
    """
    columns = math.ceil(math.sqrt(len(names)))
    width = math.ceil(max(x1 - x0 for x0, _, x1, _ in corners) + _GAP)
    height = math.ceil(max(y1 - y0 for _, y0, _, y1 in corners) + _GAP)
    if len(names) > 1 and max(width * columns, height * math.ceil(len(names) / columns)) > _MAX_EXTENT:
        raise FloorLocalizerError(
            f'{len(names)} levels of up to {width} x {height} m are too large for one map of {_MAX_EXTENT:.0f} m; '
            'make several maps'
        )
    levels = []
    for number, (name, (x0, y0, x1, y1)) in enumerate(zip(names, corners, strict=True)):
        row, column = divmod(number, columns)
        # Whole metres, to keep the rounding to single precision small.
        dx, dy = float(column * width - math.floor(x0)), float(row * height - math.floor(y0))
        levels.append(Level(name, (dx, dy), (x0 + dx, y0 + dy), (x1 + dx, y1 + dy)))
    return tuple(levels)


def level_at(levels: Sequence[Level], x: float, y: float) -> Level | None:
    """Return the level nearest to a point of the map [m], None for a map without levels."""
    return min(levels, key=lambda level: _distance(level, x, y), default=None)


def _distance(level: Level, x: float, y: float) -> float:
    dx = max(level.lower[0] - x, 0.0, x - level.upper[0])
    dy = max(level.lower[1] - y, 0.0, y - level.upper[1])
    return math.hypot(dx, dy)
