"""Dots of one image, projected to the floor, and of the map (the paper's floor dot database, 2.1)."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats
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
