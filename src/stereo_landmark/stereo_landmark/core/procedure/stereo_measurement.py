"""Corresponding points of stereo-matched primitives (paper 3.3d, 3.4)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stereo_landmark.core.primitives.primitive import Primitive, align_point_order
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, StereoPoints

NamedPair = tuple[str, Primitive, Primitive]
"""Name of a primitive, and its shape in the left and in the right image."""


def align_pair(taught: Primitive, left: Primitive, right: Primitive) -> tuple[Primitive, Primitive]:
    """Reorder the points of both shapes to correspond to those of the taught one."""
    ordered = align_point_order(left, taught)
    return ordered, align_point_order(right, ordered)


def invariant_points(primitive: Primitive) -> tuple[str, ...]:
    """Return the names of the points that are invariant to the viewpoint.

    The mean of the corners of a quadrilateral is not: in an oblique view it moves towards the farther side.
    """
    names = primitive.image_points()
    return tuple(name for name in names if not (isinstance(primitive, Quadrilateral) and name == 'centre'))


def stereo_points(pairs: Iterable[NamedPair]) -> StereoPoints:
    """Return the invariant points of primitives, named ``primitive/point``.

    Args:
        pairs: primitives whose points correspond in both images.
    """
    names: list[str] = []
    pixels: list[np.ndarray] = []
    covariances: list[np.ndarray] = []
    for name, left, right in pairs:
        here, there = left.image_points(), right.image_points()
        for point in invariant_points(left):
            names.append(f'{name}/{point}')
            pixels.append(np.concatenate([here[point].position, there[point].position]))
            covariance = np.zeros((MEASUREMENT_SIZE, MEASUREMENT_SIZE))
            covariance[:2, :2], covariance[2:, 2:] = here[point].covariance, there[point].covariance
            covariances.append(covariance)
    return StereoPoints(
        tuple(names),
        np.array(pixels).reshape(-1, MEASUREMENT_SIZE),
        np.array(covariances).reshape(-1, MEASUREMENT_SIZE, MEASUREMENT_SIZE),
    )
