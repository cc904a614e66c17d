"""Fits edge profiles across an outline in the grey image; each profile gives an offset along the normal."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.least_squares import invert_symmetric
from stereo_landmark.core.primitives.edge_response import (
    NormalEquations,
    ProfileFits,
    add_level_prior,
    interpolate_response,
)

# Minimum number of pixels for two grey levels and an offset.
_PIXELS_MIN = 8
# Largest offset for which the linear edge model holds; the next iteration measures the rest [px].
_OFFSET_MAX = 0.8
# Smallest contrast of a profile, as a fraction of the outline's median contrast.
_CONTRAST_MIN = 0.3
# Inlier gate of pixels outside the core: sigmas of the noise plus this fraction of the contrast.
_INLIER_SIGMAS = 3.0
_SHADING_TOLERANCE = 0.03
# Width of the distance bins outside the core [px], and tolerance of their mean as a fraction of the contrast.
_BIN_WIDTH = 0.5
_BIN_COUNT = 16
_MEAN_TOLERANCE = 0.015
# Largest standard deviation of an offset [px].
_SIGMA_MAX = 1.0
_QUANTIZATION_SIGMA = 12.0**-0.5


class BandPixels(NamedTuple):
    """The pixels in a band along an outline.

    Attributes:
        profiles: index of the edge profile of each pixel, shape (n,).
        distances: signed distances from the outline, positive outward or to the right, shape (n,) [px].
        directions: bins of the normal's direction, see :func:`direction_bin`, shape (n,).
        values: grey levels, shape (n,).
        visibility: fraction of the inside that adjacent edges leave visible, 1 without any, shape (n,).
        corner_terms: covariance term at corners, per unit of the response's slope, 0 elsewhere, shape (n,).
    """

    profiles: NDArray[np.int32]
    distances: Floats
    directions: NDArray[np.int32]
    values: Floats
    visibility: Floats
    corner_terms: Floats


class ProfileOffsets(NamedTuple):
    """Measured offsets of the edge profiles.

    Attributes:
        offsets: offsets of the edge from the outline along the normal, shape (k,) [px].
        sigmas: standard deviations of the offsets by image noise, infinite for unmeasured ones, shape (k,) [px].
        blur_step: correction of the blur [px].
    """

    offsets: Floats
    sigmas: Floats
    blur_step: float


@njit(cache=True, error_model='numpy')
def fit_edge_profiles(pixels: BandPixels, curves: Floats, count: int, core: float, is_straight: bool) -> ProfileOffsets:
    """Fit two grey levels, an offset and the blur to the pixels of each profile by least squares.

    Each pixel is used once, without interpolation, so the errors of the profiles are independent. A wider band
    determines the grey levels and thus the offset better, but may contain other edges. So the core of the band is
    fitted first; then inlier pixels outside it are added.

    Args:
        pixels: pixels in a band along the outline.
        curves: edge response for the present blur, shape (directions, distances, 3).
        count: number of profiles.
        core: half the width of the band's core [px].
        is_straight: whether the outline is a straight line, along which grey levels change linearly.
    """
    sums = NormalEquations(np.zeros((count, 4, 4)), np.zeros((count, 4)), np.zeros(count), np.zeros(count))
    fits = ProfileFits(np.zeros((count, 3)), np.zeros((count, 3, 3)), np.full(count, np.nan))
    _add_pixels(pixels, curves, core, fits, np.nan, sums)
    _solve(sums, fits)
    noise = max(np.sqrt(np.nanmedian(fits.residual_variances)), _QUANTIZATION_SIGMA)
    _add_pixels(pixels, curves, core, fits, noise, sums)
    _solve(sums, fits)
    if is_straight:
        noise = max(np.sqrt(np.nanmedian(fits.residual_variances)), _QUANTIZATION_SIGMA)
        add_level_prior(sums, fits, noise)
        _solve(sums, fits)
    return _profile_offsets(sums, fits)


@njit(cache=True, error_model='numpy')
def _add_pixels(
    pixels: BandPixels, curves: Floats, core: float, fits: ProfileFits, noise: float, sums: NormalEquations
) -> None:
    """Add the pixels of the core (noise is NaN), otherwise the inlier pixels outside it."""
    response = np.empty(3)
    columns = np.ones(4)
    is_outside = not np.isnan(noise)
    left, right = _clear_range(pixels, curves, core, fits, noise) if is_outside else (-core, core)
    for p in range(len(pixels.values)):
        k, value, distance = pixels.profiles[p], pixels.values[p], pixels.distances[p]
        if (abs(distance) > core) != is_outside or not left <= distance <= right:
            continue
        interpolate_response(curves[pixels.directions[p]], distance, response)
        columns[1] = response[0] * pixels.visibility[p] + response[1] * pixels.corner_terms[p]
        columns[2], columns[3] = response[1] * pixels.visibility[p], response[2] * pixels.visibility[p]
        if is_outside:
            level, contrast, shift = fits.solutions[k]
            residual = value - level - contrast * columns[1] - shift * columns[2]
            if abs(residual) > _INLIER_SIGMAS * noise + _SHADING_TOLERANCE * abs(contrast):
                continue
        for r in range(4):
            sums.rhs[k, r] += columns[r] * value
            for c in range(4):
                sums.normal[k, r, c] += columns[r] * columns[c]
        sums.squares[k] += value * value
        sums.pixel_counts[k] += 1.0


@njit(cache=True, error_model='numpy')
def _clear_range(
    pixels: BandPixels, curves: Floats, core: float, fits: ProfileFits, noise: float
) -> tuple[float, float]:
    """Return the distances to the left (negative) and to the right up to which the band is free of other edges [px].

    The blurred foot of a neighbouring edge is below the noise of a pixel, but not below that of the mean of a bin.
    """
    sums, counts = np.zeros((2, _BIN_COUNT)), np.zeros((2, _BIN_COUNT))
    contrast, response = 0.0, np.empty(3)
    for p in range(len(pixels.values)):
        k, distance = pixels.profiles[p], pixels.distances[p]
        bin_index = int((abs(distance) - core) / _BIN_WIDTH)
        if abs(distance) <= core or bin_index >= _BIN_COUNT or np.isnan(fits.residual_variances[k]):
            continue
        interpolate_response(curves[pixels.directions[p]], distance, response)
        inside = response[0] * pixels.visibility[p] + response[1] * pixels.corner_terms[p]
        residual = pixels.values[p] - fits.solutions[k, 0] - fits.solutions[k, 1] * inside
        sums[int(distance > 0.0), bin_index] += min(max(residual, -_INLIER_SIGMAS * noise), _INLIER_SIGMAS * noise)
        counts[int(distance > 0.0), bin_index] += 1.0
    contrast = np.nanmedian(np.abs(fits.solutions[:, 1]))
    limits = np.full(2, core + _BIN_COUNT * _BIN_WIDTH)
    for side in range(2):
        for bin_index in range(_BIN_COUNT):
            n = counts[side, bin_index]
            if abs(sums[side, bin_index]) > n * _MEAN_TOLERANCE * contrast + 3.0 * noise * np.sqrt(n):
                limits[side] = core + bin_index * _BIN_WIDTH
                break
    return -limits[0], limits[1]


@njit(cache=True, error_model='numpy')
def _solve(sums: NormalEquations, fits: ProfileFits) -> None:
    for k in range(len(sums.pixel_counts)):
        fits.residual_variances[k] = np.nan
        inverse = fits.inverses[k]
        if sums.pixel_counts[k] < _PIXELS_MIN or not invert_symmetric(sums.normal[k, :3, :3], inverse):
            continue
        fits.solutions[k] = inverse @ sums.rhs[k, :3]
        explained = fits.solutions[k] @ sums.rhs[k, :3]
        fits.residual_variances[k] = max(sums.squares[k] - explained, 0.0) / (sums.pixel_counts[k] - 3.0)


@njit(cache=True, error_model='numpy')
def _profile_offsets(sums: NormalEquations, fits: ProfileFits) -> ProfileOffsets:
    count = len(sums.pixel_counts)
    measured = ~np.isnan(fits.residual_variances)
    contrasts = fits.solutions[:, 1].copy()
    offsets, sigmas = np.zeros(count), np.full(count, np.inf)
    if not np.any(measured):
        return ProfileOffsets(offsets, sigmas, 0.0)
    noise = max(np.sqrt(np.nanmedian(fits.residual_variances)), _QUANTIZATION_SIGMA)
    polarity = 1 if np.median(contrasts[measured]) > 0.0 else -1
    contrasts *= polarity
    median_contrast = np.median(contrasts[measured])
    blur_rhs, blur_information = 0.0, 1e-9
    for k in range(count):
        if not measured[k] or contrasts[k] < _CONTRAST_MIN * median_contrast:
            continue
        solution, inverse = fits.solutions[k], fits.inverses[k]
        offsets[k] = min(max(-solution[2] / solution[1], -_OFFSET_MAX), _OFFSET_MAX)
        sigma = noise * np.sqrt(inverse[2, 2]) / max(contrasts[k], 1e-9)
        sigmas[k] = sigma if sigma < _SIGMA_MAX else np.inf
        # The outline has one common blur: Schur complement of its column after eliminating the profile's unknowns.
        blur = sums.normal[k, 3, :3]
        left, residual = sums.normal[k, 3, 3] - blur @ inverse @ blur, sums.rhs[k, 3] - blur @ solution
        blur_rhs += residual * solution[1]
        blur_information += left * solution[1] ** 2
    return ProfileOffsets(offsets, sigmas, blur_rhs / blur_information)
