"""Corresponding points of stereo-matched primitives (paper 3.3d, 3.4)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.primitive import Primitive, align_point_order, invariant_points, refine
from stereo_landmark.core.stereo import MEASUREMENT_SIZE, StereoPoints

NamedPair = tuple[str, Primitive, Primitive]
"""Name of a primitive, and its shape in the left and in the right image."""


def align_pair(taught: Primitive, left: Primitive, right: Primitive) -> tuple[Primitive, Primitive]:
    """Reorder the points of both shapes to correspond to those of the taught one."""
    ordered = align_point_order(left, taught)
    return ordered, align_point_order(right, ordered)


def refine_pair(
    left: Primitive, right: Primitive, images: tuple[NDArray[np.uint8], NDArray[np.uint8]]
) -> tuple[Primitive, Primitive] | None:
    """Refine a primitive in both grey images, shapes (h, w); None if it is not visible in one of them."""
    here, there = refine(left, images[0]), refine(right, images[1])
    return None if here is None or there is None else (here, there)


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
