"""Measures in the grey image how far an outline is off, section by section."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stereo_landmark.core.primitives.edge_response import look_up

# Fewer pixels do not tell two grey levels and an offset.
_PIXELS_MIN = 8
# The linear model of the edge holds for offsets of this size; the next round measures the rest [px].
_OFFSET_MAX = 0.8
# A section whose contrast is a smaller part of the outline's shows something else.
_CONTRAST_MIN = 0.3
# Outside the core a pixel agrees within so many deviations of the noise and this part of the contrast.
_AGREEING = 3.0
_SHADING = 0.03
# A section all of one grey level, or all on one side of the edge.
_SINGULAR = 1e-6
# Noise that moves the edge so far hides it [px].
_SIGMA_MAX = 1.0
_ROUNDING = 12.0**-0.5


class BandPixels(NamedTuple):
    """The pixels beside an outline.

    Attributes:
        sections: shape (n,), section of the outline beside which each lies.
        distances: shape (n,), from the outline, outward or to the right positive [px].
        directions: shape (n,), bin of the normal's direction, see :func:`direction_bin`.
        values: shape (n,) [grey levels].
    """

    sections: NDArray[np.int32]
    distances: NDArray[np.float64]
    directions: NDArray[np.int32]
    values: NDArray[np.float64]


class SectionOffsets(NamedTuple):
    """What the sections say.

    Attributes:
        offsets: shape (k,), how far the edge lies along the normal from the outline [px].
        sigmas: shape (k,), standard deviations by the noise of the image [px]; infinite where nothing was measured.
        blur_step: what is to be added to the blur [px].
    """

    offsets: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    blur_step: float


class _Sums(NamedTuple):
    """Normal equations of the sections: columns level, contrast, shift and blur, shape (k, 4, 4) and (k, 4)."""

    normal: NDArray[np.float64]
    right: NDArray[np.float64]
    squares: NDArray[np.float64]
    members: NDArray[np.float64]


class _Fits(NamedTuple):
    """Level, contrast and shift of each section, shape (k, 3); its inverse normal matrix; its mean square rest."""

    solutions: NDArray[np.float64]
    inverses: NDArray[np.float64]
    rests: NDArray[np.float64]


@njit(cache=True, error_model='numpy')
def measure_sections(
    pixels: BandPixels, profiles: NDArray[np.float64], count: int, core: float
) -> SectionOffsets:
    """Fit two grey levels, an offset and the blur to the pixels of each section by least squares.

    Each pixel counts once, as it is: nothing is interpolated, so that the sections' errors are independent.
    The farther from the edge the grey levels are taken, the better the offset is known; but other edges may
    lie there. So the core of the band is fitted first, and of the rest those pixels count that agree with it.

    Args:
        pixels: the pixels beside the outline.
        profiles: shape (directions, distances, 3), the response of an edge for the blur supposed.
        count: number of sections.
        core: half the width of the band's core [px].
    """
    sums = _Sums(np.zeros((count, 4, 4)), np.zeros((count, 4)), np.zeros(count), np.zeros(count))
    fits = _Fits(np.zeros((count, 3)), np.zeros((count, 3, 3)), np.full(count, np.nan))
    _add_pixels(pixels, profiles, core, fits, np.nan, sums)
    _solve(sums, fits)
    noise = max(np.sqrt(np.nanmedian(fits.rests)), _ROUNDING)
    _add_pixels(pixels, profiles, core, fits, noise, sums)
    _solve(sums, fits)
    return _offsets(sums, fits)


@njit(cache=True, error_model='numpy')
def _add_pixels(
    pixels: BandPixels, profiles: NDArray[np.float64], core: float, fits: _Fits, noise: float, sums: _Sums
) -> None:
    """Add the pixels of the core (noise not a number), else those outside it that agree with the fits."""
    response = np.empty(3)
    columns = np.ones(4)
    outside = not np.isnan(noise)
    for p in range(len(pixels.values)):
        k, value, distance = pixels.sections[p], pixels.values[p], pixels.distances[p]
        if (abs(distance) > core) != outside:
            continue
        look_up(profiles[pixels.directions[p]], distance, response)
        columns[1], columns[2], columns[3] = response[0], response[1], response[2]
        if outside:
            level, contrast, shift = fits.solutions[k]
            rest = value - level - contrast * response[0] - shift * response[1]
            if abs(rest) > _AGREEING * noise + _SHADING * abs(contrast):
                continue
        for r in range(4):
            sums.right[k, r] += columns[r] * value
            for c in range(4):
                sums.normal[k, r, c] += columns[r] * columns[c]
        sums.squares[k] += value * value
        sums.members[k] += 1.0


@njit(cache=True, error_model='numpy')
def _solve(sums: _Sums, fits: _Fits) -> None:
    for k in range(len(sums.members)):
        fits.rests[k] = np.nan
        inverse = fits.inverses[k]
        if sums.members[k] < _PIXELS_MIN or not _invert(sums.normal[k], inverse):
            continue
        explained = 0.0
        for r in range(3):
            total = 0.0
            for c in range(3):
                total += inverse[r, c] * sums.right[k, c]
            fits.solutions[k, r] = total
            explained += total * sums.right[k, r]
        fits.rests[k] = max(sums.squares[k] - explained, 0.0) / (sums.members[k] - 3.0)


@njit(cache=True, error_model='numpy')
def _offsets(sums: _Sums, fits: _Fits) -> SectionOffsets:
    count = len(sums.members)
    measured = ~np.isnan(fits.rests)
    contrasts = fits.solutions[:, 1].copy()
    offsets, sigmas = np.zeros(count), np.full(count, np.inf)
    if not np.any(measured):
        return SectionOffsets(offsets, sigmas, 0.0)
    noise = max(np.sqrt(np.nanmedian(fits.rests)), _ROUNDING)
    polarity = 1 if np.median(contrasts[measured]) > 0.0 else -1
    contrasts *= polarity
    typical = np.median(contrasts[measured])
    pull, weight = 0.0, 1e-9
    for k in range(count):
        if not measured[k] or contrasts[k] < _CONTRAST_MIN * typical:
            continue
        solution, inverse = fits.solutions[k], fits.inverses[k]
        offsets[k] = min(max(-solution[2] / solution[1], -_OFFSET_MAX), _OFFSET_MAX)
        sigma = noise * np.sqrt(inverse[2, 2]) / max(contrasts[k], 1e-9)
        sigmas[k] = sigma if sigma < _SIGMA_MAX else np.inf
        # The blur is one for the whole outline: of its column that part counts which the others leave.
        blur = sums.normal[k, 3]
        left, rest = blur[3], sums.right[k, 3]
        for r in range(3):
            rest -= blur[r] * solution[r]
            for c in range(3):
                left -= blur[r] * inverse[r, c] * blur[c]
        pull += rest * solution[1]
        weight += left * solution[1] ** 2
    return SectionOffsets(offsets, sigmas, pull / weight)


@njit(cache=True, error_model='numpy')
def _invert(matrix: NDArray[np.float64], inverse: NDArray[np.float64]) -> bool:
    """Write the inverse of the upper left 3 x 3 part of a symmetric matrix; False where it is singular."""
    for r in range(3):
        a, b = (r + 1) % 3, (r + 2) % 3
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            inverse[c, r] = matrix[a, d] * matrix[b, e] - matrix[a, e] * matrix[b, d]
    determinant = matrix[0, 0] * inverse[0, 0] + matrix[0, 1] * inverse[1, 0] + matrix[0, 2] * inverse[2, 0]
    if determinant < _SINGULAR * matrix[0, 0] * matrix[1, 1] * matrix[2, 2]:
        return False
    inverse /= determinant
    return True
