"""Small flat things on a floor, each an outline with a colour: chips, crumbs, hairs, scratches.

A set of outlines is an array of shape (n, v, 2). An outline with fewer than v corners repeats its last one,
which adds an edge of no length and changes neither area nor picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class FloorMarks:
    """Polygons on the floor, in the map frame.

    Attributes:
        centres: shape (n, 2), reference points [m].
        outlines: shape (n, v, 2), corners relative to the reference points [m].
        colours: shape (n, 3), reflectance in blue, green and red, 0 to 1.
        opacities: shape (n,), fraction of the ground's light that a mark hides, 0 to 1.
    """

    centres: NDArray[np.float64]
    outlines: NDArray[np.float64]
    colours: NDArray[np.float64]
    opacities: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of marks."""
        return len(self.centres)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.centres)

    @cached_property
    def _reach(self) -> float:
        """Distance of the farthest corner from its reference point [m]."""
        return float(np.hypot(self.outlines[..., 0], self.outlines[..., 1]).max(initial=0.0))

    def near(self, point: ArrayLike, radius: float) -> NDArray[np.int64]:
        """Return which marks may reach into a disc about a point, shape (2,): ascending indices, shape (k,)."""
        if len(self) == 0:
            return np.empty(0, dtype=np.int64)
        found = self._tree.query_ball_point(np.asarray(point, dtype=np.float64), radius + self._reach)
        return np.sort(np.asarray(found, dtype=np.int64))

    def select(self, indices: NDArray[np.int64] | NDArray[np.bool_]) -> FloorMarks:
        """Return the marks with these indices (or where the mask is true)."""
        return FloorMarks(self.centres[indices], self.outlines[indices], self.colours[indices], self.opacities[indices])

    def corners(self) -> NDArray[np.float64]:
        """Return all corners in the map frame, shape (n, v, 2) [m]."""
        return np.asarray(self.centres[:, None] + self.outlines)


def polygon_areas(outlines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the signed areas of polygons, shape (n, v, 2) to (n,), positive when counter-clockwise [m^2]."""
    following = np.roll(outlines, -1, axis=1)
    return 0.5 * _cross(outlines, following).sum(axis=1)


def polygon_centroids(outlines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the area centroids of polygons, shape (n, v, 2) to (n, 2) [m]."""
    following = np.roll(outlines, -1, axis=1)
    moments = ((outlines + following) * _cross(outlines, following)[..., None]).sum(axis=1)
    return np.asarray(moments / (6.0 * polygon_areas(outlines))[:, None])


def random_chips(
    diameters: NDArray[np.float64],
    rng: np.random.Generator,
    *,
    corners: tuple[int, int] = (5, 8),
    roughness: float = 0.2,
    elongation: float = 1.5,
) -> NDArray[np.float64]:
    """Return irregular, nearly convex polygons as crushed plastic leaves them.

    Corners are at uneven steps around an ellipse and are pushed inwards at random; then each polygon is
    turned at random, moved to have its area centroid at the origin and scaled to its area.

    Args:
        diameters: shape (n,), diameters of the discs of equal area [m].
        rng: source of randomness.
        corners: least and greatest number of corners.
        roughness: largest fraction of the radius by which a corner is pushed inwards.
        elongation: greatest ratio of length to width.

    Returns:
        array, shape (n, corners[1], 2), counter-clockwise corners about the area centroid [m].
    """
    n, most = len(diameters), corners[1]
    counts = rng.integers(corners[0], most + 1, size=(n, 1))
    places = np.minimum(np.arange(most), counts - 1)
    steps = np.take_along_axis(rng.uniform(0.0, 0.8, (n, most)), places, axis=1)
    radii = np.take_along_axis(rng.uniform(1.0 - roughness, 1.0, (n, most)), places, axis=1)
    angles = math.tau * (places + steps) / counts
    stretch = np.sqrt(rng.uniform(1.0, elongation, (n, 1)))
    outlines = np.stack([radii * np.cos(angles) * stretch, radii * np.sin(angles) / stretch], axis=-1)
    outlines = _rotate(outlines, rng.uniform(0.0, math.tau, n))
    outlines -= polygon_centroids(outlines)[:, None]
    scale = 0.5 * diameters * np.sqrt(math.pi / polygon_areas(outlines))
    return np.asarray(outlines * scale[:, None, None])


def random_ribbons(
    lengths: NDArray[np.float64],
    widths: NDArray[np.float64],
    bend: float,
    rng: np.random.Generator,
    *,
    joints: int = 24,
) -> NDArray[np.float64]:
    """Return thin, randomly bent bands: hairs (much bend) or scratches (little).

    Args:
        lengths: shape (n,), lengths along the middle line [m].
        widths: shape (n,), full widths [m].
        bend: standard deviation of the whole turn from one end to the other [rad].
        rng: source of randomness.
        joints: number of points along the middle line.

    Returns:
        array, shape (n, 2 * joints, 2), corners about the mean of the middle line [m].
    """
    n = len(lengths)
    curvature = np.cumsum(rng.normal(size=(n, joints)), axis=1) / math.sqrt(joints)
    headings = np.cumsum(rng.normal(size=(n, 1)) + curvature, axis=1) * (bend / joints)
    headings += rng.uniform(0.0, math.tau, (n, 1))
    tangents = np.stack([np.cos(headings), np.sin(headings)], axis=-1)
    middle = np.cumsum(tangents, axis=1) * (lengths / joints)[:, None, None]
    middle -= middle.mean(axis=1, keepdims=True)
    sideways = np.stack([-tangents[..., 1], tangents[..., 0]], axis=-1) * (0.5 * widths)[:, None, None]
    return np.concatenate([middle - sideways, (middle + sideways)[:, ::-1]], axis=1)


def _cross(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the z components of cross products of plane vectors, shape (..., 2) to (...)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def _rotate(outlines: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each outline turned about the origin by its angle [rad]."""
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    x, y = outlines[..., 0], outlines[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
