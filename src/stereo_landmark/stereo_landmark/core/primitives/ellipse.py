"""Ellipses: round meters, dials, holes, pipe ends (paper 3.3c)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from shirube_core.settings import setting
from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.edges.segments import Segments
from stereo_landmark.core.primitives.ellipse import refine_outline
from stereo_landmark.core.primitives.ellipse_fit import find_arcs, normal_jacobian
from stereo_landmark.core.primitives.ellipse_search import EllipseLimits, search_ellipses
from stereo_landmark.core.primitives.shape import ImagePoint, wrap_differences
from stereo_landmark.core.settings import PrimitiveSettings

# Prior of the tilt, which a circle does not determine [rad].
TILT_SIGMA = 1.0
# Neighbouring edge points have correlated noise [points]; lower limit of the noise of one point [px].
_NOISE_CORRELATION = 3.0
_SIGMA_MIN = 0.05
_OUTLINE_STEPS = 48


@dataclass(frozen=True, eq=False)
class Ellipse:
    """An ellipse in an image; angles are counted from x (right) to y (down).

    The centre of a circle's image is not the image of the circle's centre: in an oblique view it is shifted
    towards the near rim. The shift is nearly equal in both cameras of a narrow baseline, and from poses near
    the taught one.

    Attributes:
        centre: centre of the ellipse, shape (2,) [px].
        semi_axes: semi-axes, the longer first, shape (2,) [px].
        tilt: direction of the longer axis, in (-pi/2, pi/2] [rad]; meaningless for a circle.
        polarity: 1 if the inside is bright, -1 if it is dark.
        seen: fraction of the outline with edges.
        covariance: covariance of centre x, y, both semi-axes [px] and tilt [rad], shape (5, 5).
    """

    centre: Floats
    semi_axes: Floats
    tilt: float
    polarity: int
    seen: float
    covariance: Floats

    @property
    def parameters(self) -> Floats:
        """Centre x, y, both semi-axes [px] and tilt [rad], shape (5,)."""
        return np.array([*self.centre, *self.semi_axes, self.tilt])

    @property
    def shape_vector(self) -> tuple[float, ...]:
        """Semi-axes [px], tilt [rad] and polarity."""
        return *self.semi_axes, self.tilt, self.polarity

    def outline(self) -> list[Floats]:
        """Return the closed outline as a polyline, shape (n, 2) [px]."""
        angles = np.linspace(0.0, math.tau, _OUTLINE_STEPS + 1)
        cos, sin = math.cos(self.tilt), math.sin(self.tilt)
        along, across = self.semi_axes[0] * np.cos(angles), self.semi_axes[1] * np.sin(angles)
        return [self.centre + np.column_stack([cos * along - sin * across, sin * along + cos * across])]

    def image_points(self) -> dict[str, ImagePoint]:
        """Return the candidates for corresponding points, by name."""
        return {'centre': ImagePoint(self.centre, self.covariance[:2, :2])}


@dataclass(frozen=True)
class EllipseTolerance:
    """Tolerances between a detected ellipse and the taught one."""

    axes: float = setting(0.5, 'relative tolerance of the semi-axes', minimum=0.01, maximum=5.0)
    tilt: float = setting(
        0.35,
        'tolerance of the tilt of a flat ellipse; less weight for rounder ones',
        unit='rad',
        minimum=0.01,
        maximum=1.6,
    )


def ellipse_differences(found: Floats, taught: Floats, tolerance: EllipseTolerance) -> Floats:
    """Return the differences of detected from taught shape vectors, shape (k, n).

    Args:
        found: shape vectors of the detected ellipses, shape (n, 4).
        taught: shape vectors of the taught ellipses, shape (k, 4).
        tolerance: tolerances, at which the difference is 1.
    """
    mine, theirs = found.T[:, None, :], taught.T[:, :, None]
    axes = np.abs(np.log(mine[:2] / theirs[:2])).max(axis=0) / math.log1p(tolerance.axes)
    roundness = mine[1] / mine[0] * theirs[1] / theirs[0]
    tilts = np.abs(wrap_differences(mine[2] - theirs[2], math.pi)) / tolerance.tilt
    return np.where(mine[3] == theirs[3], np.maximum(axes, (1.0 - roundness) * tilts), math.inf)


def detect_ellipses(segments: Segments, settings: PrimitiveSettings) -> list[Ellipse]:
    """Detect ellipses; their outlines may be broken or partly occluded.

    Args:
        segments: segments of the image.
        settings: detection settings.

    Returns:
        ellipses without duplicates, by falling length of the visible outline.
    """
    spans, shapes = find_arcs(segments.points, segments.vertex_indices, segments.vertex_starts)
    limits = EllipseLimits(
        settings.ellipse_axis_min,
        settings.ellipse_axis_max,
        settings.ellipse_flatness_min,
        settings.ellipse_seen_min,
    )
    rows = search_ellipses(segments.points, segments.gradients, segments.index, spans, shapes, limits)
    rows = rows[np.argsort(-rows[:, 6] * rows[:, 2:4].sum(axis=1), kind='stable')]
    return [_make_ellipse(rows[k]) for k in _suppress_duplicates(rows)]


def refine_ellipse(ellipse: Ellipse, image: GreyImage) -> Ellipse | None:
    """Refine an ellipse in the grey image by edge profiles across its outline.

    Args:
        ellipse: detected ellipse, off by about a pixel at most.
        image: grey image, shape (h, w).

    Returns:
        refined ellipse with the covariance by image noise and scatter of the outline, None if the image does not
        show it there.
    """
    refined = refine_outline(image, ellipse.parameters)
    if refined is None:
        return None
    parameters, covariance = refined.parameters, refined.covariance
    if parameters[2] < parameters[3]:
        # The axes were swapped.
        order = [0, 1, 3, 2, 4]
        parameters, covariance = parameters[order], covariance[np.ix_(order, order)]
        parameters[4] += 0.5 * math.pi
    tilt = 0.5 * math.pi - math.remainder(0.5 * math.pi - float(parameters[4]), math.pi)
    return Ellipse(
        *(parameters[:2], parameters[2:4], tilt, ellipse.polarity, refined.inlier_fraction),
        covariance=covariance,
    )


def _suppress_duplicates(rows: Floats) -> list[int]:
    """Return the indices of the ellipses to keep, the first of each group of duplicates."""
    kept: list[int] = []
    for k, row in enumerate(rows):
        if not any(np.abs(row[:4] - rows[other, :4]).max() < _DUPLICATE_DISTANCE for other in kept):
            kept.append(k)
    return kept


# Ellipses whose centre and axes differ by less are duplicates [px].
_DUPLICATE_DISTANCE = 2.0


def _make_ellipse(row: Floats) -> Ellipse:
    parameters = np.ascontiguousarray(row[:5])
    step = max(1.0, 2.0 * math.pi * row[2] / 64.0)
    jacobian = normal_jacobian(parameters, 64)
    variance = max(row[7], _SIGMA_MIN) ** 2 * _NOISE_CORRELATION / (step * row[6])
    information = jacobian.T @ jacobian / variance + np.diag([0.0, 0.0, 0.0, 0.0, TILT_SIGMA**-2])
    return Ellipse(
        *(parameters[:2], parameters[2:4], float(parameters[4]), int(row[5]), float(row[6])),
        covariance=np.linalg.inv(information),
    )
