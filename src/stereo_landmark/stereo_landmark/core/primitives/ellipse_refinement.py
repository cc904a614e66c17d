"""Subpixel refinement of an ellipse by edge profiles across its outline."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from stereo_landmark.core.arrays import Floats, GreyImage
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
    foot_point,
    normal_jacobian_row,
    perimeter,
)
from stereo_landmark.core.primitives.line_refinement import (
    INITIAL_BLUR,
    ITERATIONS_MAX,
    STEP_TOLERANCE,
    band_core,
    band_width,
    next_blur,
)

_PROFILE_LENGTH = 6.0
_PROFILES_MIN = 16
# Largest band half-width, as a fraction of the shorter semi-axis.
_BAND_AXIS_FRACTION = 0.6
# Prior information on the tilt, which a circle does not determine [1 / rad²].
_TILT_INFORMATION = 1.0


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
    return BandPixels(
        profiles[:n], distances[:n], directions[:n], values[:n], np.ones(n), np.zeros(n)
    ), jacobian


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
