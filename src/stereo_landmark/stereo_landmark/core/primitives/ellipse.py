"""Ellipses: round meters, dials, holes, pipes' ends (paper 3.3c)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shirube_settings import setting
from stereo_landmark.core.primitives.arcs import find_arcs
from stereo_landmark.core.primitives.ellipse_geometry import normal_motions
from stereo_landmark.core.primitives.ellipse_refinement import refine_outline
from stereo_landmark.core.primitives.ellipse_search import EllipseLimits, search_ellipses
from stereo_landmark.core.primitives.image_point import ImagePoint
from stereo_landmark.core.primitives.settings import PrimitiveSettings
from stereo_landmark.core.primitives.turning import folded, folded_all
from stereo_landmark.core.segments.segments import Segments

# What is known of the tilt of a circle: next to nothing [rad].
TILT_SIGMA = 1.0
# Neighbouring edge points share their noise; that of one is never smaller [points, px].
_CORRELATED = 3.0
_SIGMA_MIN = 0.05


@dataclass(frozen=True)
class Ellipse:
    """An ellipse in an image; angles are counted from x (right) to y (down).

    The centre of the image of a circle is not the image of its centre: seen at an angle, it lies nearer to
    the near rim. Both cameras of a narrow pair see nearly the same displacement, and so does the robot from
    a place near the taught one.

    Attributes:
        centre: shape (2,) [px].
        semi_axes: shape (2,), the longer first [px].
        tilt: direction of the longer axis, in (-pi/2, pi/2] [rad]; says nothing for a circle.
        polarity: 1 where the inside is bright, -1 where it is dark.
        seen: part of the outline where there are edges.
        covariance: shape (5, 5), of centre x, y, both semi-axes and tilt.
    """

    centre: NDArray[np.float64]
    semi_axes: NDArray[np.float64]
    tilt: float
    polarity: int
    seen: float
    covariance: NDArray[np.float64]

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Centre x, y, both semi-axes [px] and tilt [rad], shape (5,)."""
        return np.array([*self.centre, *self.semi_axes, self.tilt])

    def image_points(self) -> dict[str, ImagePoint]:
        """Return the points that may serve as corresponding points, by name."""
        return {'centre': ImagePoint(self.centre, self.covariance[:2, :2])}


@dataclass(frozen=True)
class EllipseTolerance:
    """How far an ellipse may differ from the taught one."""

    axes: float = setting(0.5, 'difference of a semi-axis, as a part of it', minimum=0.01, maximum=5.0)
    tilt: float = setting(
        0.35,
        'difference of the tilt of a flat ellipse; round ones have none',
        unit='rad',
        minimum=0.01,
        maximum=1.6,
    )


def ellipse_difference(found: Ellipse, taught: Ellipse, tolerance: EllipseTolerance) -> float:
    """Return how much an ellipse differs: 0 not at all, 1 just tolerated, infinite with the other polarity."""
    return float(ellipse_differences(ellipse_numbers([found]), ellipse_numbers([taught]), tolerance)[0, 0])


def ellipse_differences(
    found: NDArray[np.float64], taught: NDArray[np.float64], tolerance: EllipseTolerance
) -> NDArray[np.float64]:
    """Return how much each differs from each taught one, shape (k, n).

    Args:
        found: shape (n, 4), see :func:`ellipse_numbers`.
        taught: shape (k, 4).
        tolerance: what is just tolerated.
    """
    mine, theirs = found.T[:, None, :], taught.T[:, :, None]
    axes = np.abs(np.log(mine[:2] / theirs[:2])).max(axis=0) / math.log1p(tolerance.axes)
    roundness = mine[1] / mine[0] * theirs[1] / theirs[0]
    tilts = np.abs(folded_all(mine[2] - theirs[2], math.pi)) / tolerance.tilt
    return np.where(mine[3] == theirs[3], np.maximum(axes, (1.0 - roundness) * tilts), math.inf)


def ellipse_numbers(ellipses: Sequence[Ellipse]) -> NDArray[np.float64]:
    """Return the shapes as numbers, shape (n, 4): semi-axes [px], tilt [rad] and polarity."""
    return np.array([(*each.semi_axes, each.tilt, each.polarity) for each in ellipses]).reshape(-1, 4)


def detect_ellipses(segments: Segments, settings: PrimitiveSettings) -> list[Ellipse]:
    """Find ellipses whose outline may be broken or partly hidden.

    Args:
        segments: segments of the image.
        settings: what is taken for an ellipse.

    Returns:
        each ellipse once, those with the longest outline seen first.
    """
    spans, shapes = find_arcs(segments.points, segments.bends, segments.bend_starts)
    limits = EllipseLimits(
        settings.ellipse_axis_min,
        settings.ellipse_axis_max,
        settings.ellipse_flatness_min,
        settings.ellipse_seen_min,
    )
    rows = search_ellipses(segments.points, segments.gradients, segments.index, spans, shapes, limits)
    rows = rows[np.argsort(-rows[:, 6] * rows[:, 2:4].sum(axis=1), kind='stable')]
    return [_ellipse(rows[k]) for k in _distinct(rows)]


def refine_ellipse(ellipse: Ellipse, image: NDArray[np.uint8]) -> Ellipse | None:
    """Measure an ellipse in the grey image, across its outline.

    Args:
        ellipse: a detected ellipse, about a pixel off at most.
        image: shape (h, w), grey levels.

    Returns:
        the ellipse with the covariance that the noise and the scatter of its outline give it, None where the
        image shows none there.
    """
    refined = refine_outline(image, ellipse.parameters)
    if refined is None:
        return None
    parameters, covariance = refined.parameters, refined.covariance
    if parameters[2] < parameters[3]:
        # The axes have changed places.
        order = [0, 1, 3, 2, 4]
        parameters, covariance = parameters[order], covariance[np.ix_(order, order)]
        parameters[4] += 0.5 * math.pi
    tilt = 0.5 * math.pi - folded(0.5 * math.pi - float(parameters[4]), math.pi)
    return Ellipse(
        *(parameters[:2], parameters[2:4], tilt, ellipse.polarity, refined.agreeing), covariance=covariance
    )


def _distinct(rows: NDArray[np.float64]) -> list[int]:
    """Return which ellipses to keep, the first of those that nearly agree."""
    kept: list[int] = []
    for k, row in enumerate(rows):
        if not any(np.abs(row[:4] - rows[other, :4]).max() < _SAME for other in kept):
            kept.append(k)
    return kept


# Ellipses that differ by less in centre and axes are one [px].
_SAME = 2.0


def _ellipse(row: NDArray[np.float64]) -> Ellipse:
    parameters = np.ascontiguousarray(row[:5])
    step = max(1.0, 2.0 * math.pi * row[2] / 64.0)
    jacobian = normal_motions(parameters, 64)
    variance = max(row[7], _SIGMA_MIN) ** 2 * _CORRELATED / (step * row[6])
    information = jacobian.T @ jacobian / variance + np.diag([0.0, 0.0, 0.0, 0.0, TILT_SIGMA**-2])
    return Ellipse(
        *(parameters[:2], parameters[2:4], float(parameters[4]), int(row[5]), float(row[6])),
        covariance=np.linalg.inv(information),
    )
