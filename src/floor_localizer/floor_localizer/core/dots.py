"""Dots of one image, projected to the floor, and of the map (the paper's floor dot database, 2.1) with its levels.

The levels are the floors of a building, side by side in one map frame, so that one index covers them all.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats
from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2

# Maximum distance between two observations of the same dot [standard deviations].
_SAME_DOT_SIGMAS = 4.0


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
    """Dots on the floor.

    Attributes:
        points: shape (n, 2), positions in the base frame [m].
        sigmas: shape (n,), standard deviations along each axis [m].
    """

    points: Floats
    sigmas: Floats


def transform_points(points: FloorPoints, T_new_old: SE2, odometry_error: float) -> FloorPoints:
    """Transform points to the base frame at a later time, in which the old one is ``T_new_old`` by odometry.

    ``odometry_error`` is a fraction of the distance driven.
    """
    distance = math.hypot(T_new_old.x, T_new_old.y)
    return FloorPoints(
        T_new_old.transform(points.points), np.hypot(points.sigmas, odometry_error * distance / 3.0)
    )


def merge_points(first: FloorPoints, second: FloorPoints) -> FloorPoints:
    """Return the union of two sets of points; points of the first that also are in the second are dropped."""
    if len(first.points) == 0 or len(second.points) == 0:
        return second if len(first.points) == 0 else first
    distances, nearest = cKDTree(second.points).query(first.points)
    is_new = distances > _SAME_DOT_SIGMAS * np.hypot(first.sigmas, second.sigmas[nearest])
    return FloorPoints(
        np.vstack([second.points, first.points[is_new]]),
        np.concatenate([second.sigmas, first.sigmas[is_new]]),
    )


@dataclass(frozen=True)
class DotMap:
    """All dots of a floor in the map frame.

    Attributes:
        points: shape (N, 2), centres of the dots [m].
        diameters: shape (N,), diameters of the discs of equal area [m], NaN where unknown.
    """

    points: Floats
    diameters: Floats

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.points)


# Gap between levels, larger than any constellation [m].
_GAP = 2.0
# Largest extent of the map; single precision resolves 0.03 mm there [m].
_MAX_EXTENT = 1024.0


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


def arrange_levels(
    names: Sequence[str], corners: Sequence[tuple[float, float, float, float]]
) -> tuple[Level, ...]:
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
