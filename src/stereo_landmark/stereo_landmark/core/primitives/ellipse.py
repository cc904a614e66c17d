"""Ellipses: round meters, dials, holes, pipe ends (paper 3.3c)."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from shirube_core.settings import setting
from stereo_landmark.core.arrays import Floats, GreyImage
from stereo_landmark.core.edges.edges import Segments
from stereo_landmark.core.least_squares import robust_step
from stereo_landmark.core.primitives.edge_profiles import BandPixels, fit_edge_profiles
from stereo_landmark.core.primitives.edge_response import (
    BLURS,
    PIXEL_VARIANCE,
    direction_bin,
    nearest_blur,
    response_table,
)
from stereo_landmark.core.primitives.ellipse_fit import (
    ellipse_point,
    find_arcs,
    foot_point,
    normal_jacobian,
    normal_jacobian_row,
    perimeter,
)
from stereo_landmark.core.primitives.ellipse_search import EllipseLimits, search_ellipses
from stereo_landmark.core.primitives.line_refinement import (
    INITIAL_BLUR,
    ITERATIONS_MAX,
    STEP_TOLERANCE,
    band_core,
    band_width,
    next_blur,
)
from stereo_landmark.core.primitives.shape import ImagePoint, wrap_differences
from stereo_landmark.core.settings import PrimitiveSettings

# Prior of the tilt, which a circle does not determine [rad]; its information [1 / rad²].
TILT_SIGMA = 1.0
_TILT_INFORMATION = 1.0
# Neighbouring edge points have correlated noise [points]; lower limit of the noise of one point [px].
_NOISE_CORRELATION, _SIGMA_MIN = 3.0, 0.05
_OUTLINE_STEPS = 48
_PROFILE_LENGTH = 6.0
_PROFILES_MIN = 16
# Largest band half-width, as a fraction of the shorter semi-axis.
_BAND_AXIS_FRACTION = 0.6
# Ellipses whose centre and axes differ by less are duplicates [px].
_DUPLICATE_DISTANCE = 2.0


@dataclass(frozen=True, eq=False)
class Ellipse:
    """An ellipse in an image; angles are counted from x (right) to y (down).

    The centre of a circle's image is not the image of the circle's centre: in an oblique view it is shifted towards
    the near rim, nearly equally in both cameras of a narrow baseline and from poses near the taught one.

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

    axes: float = setting(0.5, 'relative tolerance of the semi-axes', limits=(0.01, 5.0))
    tilt: float = setting(
        0.35, 'tolerance of the tilt of a flat ellipse; less weight for rounder ones', 'rad', (0.01, 1.6)
    )


def ellipse_differences(found: Floats, taught: Floats, tolerance: EllipseTolerance) -> Floats:
    """Return the differences of detected, shape (n, 4), from taught shape vectors, (k, 4), shape (k, n)."""
    mine, theirs = found.T[:, None, :], taught.T[:, :, None]
    axes = np.abs(np.log(mine[:2] / theirs[:2])).max(axis=0) / math.log1p(tolerance.axes)
    roundness = mine[1] / mine[0] * theirs[1] / theirs[0]
    tilts = np.abs(wrap_differences(mine[2] - theirs[2], math.pi)) / tolerance.tilt
    return np.where(mine[3] == theirs[3], np.maximum(axes, (1.0 - roundness) * tilts), math.inf)


def detect_ellipses(segments: Segments, settings: PrimitiveSettings) -> list[Ellipse]:
    """Detect ellipses; their outlines may be broken or partly occluded.

    Returns:
        ellipses without duplicates, by falling length of the visible outline.
    """
    spans, shapes = find_arcs(segments.points, segments.vertex_indices, segments.vertex_starts)
    limits = EllipseLimits(
        settings.ellipse_axis_min, settings.ellipse_axis_max, settings.ellipse_flatness_min, settings.ellipse_seen_min
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
        *(parameters[:2], parameters[2:4], tilt, ellipse.polarity, refined.inlier_fraction), covariance=covariance
    )


def _suppress_duplicates(rows: Floats) -> list[int]:
    """Return the indices of the ellipses to keep, the first of each group of duplicates."""
    kept: list[int] = []
    for k, row in enumerate(rows):
        if not any(np.abs(row[:4] - rows[other, :4]).max() < _DUPLICATE_DISTANCE for other in kept):
            kept.append(k)
    return kept


def _make_ellipse(row: Floats) -> Ellipse:
    parameters = np.ascontiguousarray(row[:5])
    step, jacobian = max(1.0, 2.0 * math.pi * row[2] / 64.0), normal_jacobian(parameters, 64)
    variance = max(row[7], _SIGMA_MIN) ** 2 * _NOISE_CORRELATION / (step * row[6])
    information = jacobian.T @ jacobian / variance + np.diag([0.0, 0.0, 0.0, 0.0, TILT_SIGMA**-2])
    return Ellipse(
        *(parameters[:2], parameters[2:4], float(parameters[4]), int(row[5]), float(row[6])),
        covariance=np.linalg.inv(information),
    )


class RefinedEllipse(NamedTuple):
    """Parameters of the ellipse, shape (5,), their covariance, and the inlier fraction of the profiles."""

    parameters: Floats
    covariance: Floats
    inlier_fraction: float


def refine_outline(image: GreyImage, parameters: Floats) -> RefinedEllipse | None:
    """Refine an ellipse by edge profiles across its outline.

    Args:
        image: grey image, shape (h, w).
        parameters: centre x, y, semi-axes [px], tilt [rad], shape (5,); the outline is off by about a pixel at most.

    Returns:
        refined ellipse, None if the image does not show it there.
    """
    found, refined = _refine(image, parameters, response_table())
    return refined if found else None


@njit(cache=True, error_model='numpy')
def _refine(image: GreyImage, parameters: Floats, table: Floats) -> tuple[bool, RefinedEllipse]:
    """Iterate the refinement; return whether it succeeded, and the ellipse."""
    refined = RefinedEllipse(parameters.copy(), np.eye(5), 0.0)
    prior = np.array([0.0, 0.0, 0.0, 0.0, _TILT_INFORMATION])
    blur_index = nearest_blur(INITIAL_BLUR)
    for _ in range(ITERATIONS_MAX):
        current, blur = refined.parameters, BLURS[blur_index]
        count = max(_PROFILES_MIN, int(np.rint(perimeter(current[2], current[3]) / _PROFILE_LENGTH)))
        width = min(band_width(blur), _BAND_AXIS_FRACTION * current[3])
        pixels, jacobian = _outline_band(image, current, width, count, blur**2 + PIXEL_VARIANCE)
        found = fit_edge_profiles(pixels, table[blur_index], count, min(band_core(blur), width), False)
        fit = robust_step(jacobian, found.offsets, found.sigmas, prior)
        refined = RefinedEllipse(current + fit.step, fit.covariance, fit.inlier_fraction)
        if not fit.found or np.min(refined.parameters[2:4]) < 1.0:
            return False, refined
        previous, blur_index = blur_index, nearest_blur(next_blur(blur, found.blur_step))
        if np.max(np.abs(fit.step[:4])) < STEP_TOLERANCE and blur_index == previous:
            break
    return True, refined


@njit(cache=True, error_model='numpy')
def _outline_band(
    image: GreyImage, parameters: Floats, width: float, count: int, variance: float
) -> tuple[BandPixels, Floats]:
    """Return the pixels in a band along the outline, and the Jacobian of the profile offsets, shape (count, 5)."""
    height, columns = image.shape
    cx, cy, a, b, tilt = parameters
    bounds = _profile_bounds(parameters, count)
    jacobian = np.empty((count, 5))
    for k in range(count):
        normal_jacobian_row(parameters, 0.5 * (bounds[k] + bounds[k + 1]), jacobian[k])
    capacity = int(perimeter(a, b) * 2.0 * width * 1.3) + 64
    profiles, directions = np.empty(capacity, np.int32), np.empty(capacity, np.int32)
    distances, values = np.empty(capacity), np.empty(capacity)
    cos_r, sin_r = np.cos(tilt), np.sin(tilt)
    extent_x = np.hypot(a * cos_r, b * sin_r) + width
    extent_y = np.hypot(a * sin_r, b * cos_r) + width
    n = 0
    for y in range(max(0, int(cy - extent_y)), min(height, int(cy + extent_y) + 2)):
        for x in range(max(0, int(cx - extent_x)), min(columns, int(cx + extent_x) + 2)):
            u, v = cos_r * (x - cx) + sin_r * (y - cy), cos_r * (y - cy) - sin_r * (x - cx)
            if not _is_in_band(u, v, a, b, width):
                continue
            cos_t, sin_t, speed = foot_point(a, b, u, v)
            nu, nv = b * cos_t / speed, a * sin_t / speed
            distance = (u - a * cos_t) * nu + (v - b * sin_t) * nv
            if abs(distance) > width or n == capacity:
                continue
            t = np.arctan2(sin_t, cos_t)
            profiles[n] = min(np.searchsorted(bounds, t % (2.0 * np.pi), side='right') - 1, count - 1)
            # Blur shifts the half-level point of a curved edge towards its concave side.
            distances[n] = distance + 0.5 * variance * a * b / speed**3
            directions[n] = direction_bin(cos_r * nu - sin_r * nv, sin_r * nu + cos_r * nv)
            values[n] = image[y, x]
            n += 1
    return BandPixels(profiles[:n], distances[:n], directions[:n], values[:n], np.ones(n), np.zeros(n)), jacobian


@njit(cache=True, error_model='numpy')
def _is_in_band(u: float, v: float, a: float, b: float, width: float) -> bool:
    outer = (u / (a + width)) ** 2 + (v / (b + width)) ** 2
    inner = (u / (a - width)) ** 2 + (v / (b - width)) ** 2
    return outer <= 1.0 and inner >= 1.0


@njit(cache=True, error_model='numpy')
def _profile_bounds(parameters: Floats, count: int) -> Floats:
    """Return the curve parameters between profiles of equal arc length, shape (count + 1,), from 0 to 2 pi [rad]."""
    fine = 8 * count
    lengths = np.zeros(fine + 1)
    for i in range(fine):
        lengths[i + 1] = lengths[i] + ellipse_point(parameters, (i + 0.5) * 2.0 * np.pi / fine)[4]
    wanted = lengths[-1] * np.arange(count + 1) / count
    return np.interp(wanted, lengths, np.arange(fine + 1) * 2.0 * np.pi / fine)
