"""Finds quadrilaterals that are not rectangles in 3D: their sides belong to different objects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stereo_landmark.core.place.stereo_points import SpatialPoints
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.primitive import Primitive

SKEW_MAX = 0.05
"""Opposite sides of a rectangle differ in 3D by a smaller fraction than this,"""
SKEW_SIGMAS = 5.0
"""or by fewer standard deviations."""


def find_skewed_shapes(
    shapes: Mapping[str, Primitive], coordinates: SpatialPoints
) -> Iterator[tuple[str, str]]:
    """Yield name and warning of each quadrilateral that is not a rectangle in 3D.

    If one side is matched to another edge in one of the images, such as the frame around a panel, two corners are
    triangulated far behind or in front of the wall, with small stated covariances.

    Args:
        shapes: primitives by their names.
        coordinates: 3D points, named ``name/point``.
    """
    for name, shape in shapes.items():
        if not isinstance(shape, Quadrilateral):
            continue
        corners = coordinates.select(tuple(f'{name}/corner_{k}' for k in range(4)))
        skew, lengths = _skew(corners)
        if skew > 1.0:
            one, other = (f'{100.0 * length:.1f}' for length in lengths)
            text = (
                f'{name}: its opposite sides are {one} and {other} cm long in 3D; a rectangle is probably mismatched: '
                'select another primitive'
            )
            yield name, text


def _skew(corners: SpatialPoints) -> tuple[float, tuple[float, float]]:
    """Return the skew, above 1 for anything but a rectangle, and the lengths of the opposite sides [m]."""
    sides = [_side(corners, k) for k in range(4)]
    worst = 0.0, (0.0, 0.0)
    for (one, variance), (other, other_variance) in zip(sides[:2], sides[2:], strict=True):
        gap = abs(one - other)
        skew = min(
            gap / (SKEW_MAX * max(one, other)),
            gap / (SKEW_SIGMAS * float(np.sqrt(variance + other_variance))),
        )
        worst = max(worst, (skew, (one, other)))
    return worst


def _side(corners: SpatialPoints, k: int) -> tuple[float, float]:
    """Return the length of a side [m] and its variance [m²]."""
    other = (k + 1) % 4
    side = corners.positions[other] - corners.positions[k]
    length = float(np.linalg.norm(side))
    along = side / length
    return length, float(along @ (corners.covariances[k] + corners.covariances[other]) @ along)
