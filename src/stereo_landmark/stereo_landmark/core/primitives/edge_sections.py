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
# A section all of one grey level, or all on one side of the edge.
_SINGULAR = 1e-6
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
        polarity: 1 where it is brighter at positive distances, else -1.
    """

    offsets: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    blur_step: float
    polarity: int


@njit(cache=True, error_model='numpy')
def measure_sections(pixels: BandPixels, profiles: NDArray[np.float64], count: int) -> SectionOffsets:
    """Fit two grey levels, an offset and the blur to the pixels of each section by least squares.

    Each pixel counts once, as it is: nothing is interpolated, so that the sections' errors are independent.

    Args:
        pixels: the pixels beside the outline.
        profiles: shape (directions, distances, 3), the response of an edge for the blur supposed.
        count: number of sections.
    """
    normal, right = np.zeros((count, 4, 4)), np.zeros((count, 4))
    squares, members = np.zeros(count), np.zeros(count)
    response = np.empty(3)
    columns = np.ones(4)
    for p in range(len(pixels.values)):
        k, value = pixels.sections[p], pixels.values[p]
        look_up(profiles[pixels.directions[p]], pixels.distances[p], response)
        columns[1:] = response
        for r in range(4):
            right[k, r] += columns[r] * value
            for c in range(r, 4):
                normal[k, r, c] += columns[r] * columns[c]
        squares[k] += value * value
        members[k] += 1.0
    return _solve_sections(normal, right, squares, members)


@njit(cache=True, error_model='numpy')
def _solve_sections(
    normal: NDArray[np.float64],
    right: NDArray[np.float64],
    squares: NDArray[np.float64],
    members: NDArray[np.float64],
) -> SectionOffsets:
    count = len(members)
    contrasts, offsets, spreads = np.zeros(count), np.zeros(count), np.full(count, np.inf)
    inverse = np.empty((3, 3))
    rests, blurs, blur_weights = np.full(count, np.nan), np.zeros(count), np.zeros(count)
    for k in range(count):
        for r in range(4):
            for c in range(r):
                normal[k, r, c] = normal[k, c, r]
        if members[k] < _PIXELS_MIN or not _invert(normal[k], inverse):
            continue
        solution = inverse @ right[k, :3]
        contrasts[k] = solution[1]
        offsets[k] = -solution[2] / solution[1]
        spreads[k] = np.sqrt(inverse[2, 2]) / abs(solution[1])
        rests[k] = max(squares[k] - np.dot(solution, right[k, :3]), 0.0) / max(members[k] - 3.0, 1.0)
        # The blur is one for the whole outline: its column's share that the others leave.
        across = inverse @ normal[k, :3, 3].copy()
        left = normal[k, 3, 3] - np.dot(normal[k, 3, :3], across)
        blurs[k] = (right[k, 3] - np.dot(across, right[k, :3])) * solution[1]
        blur_weights[k] = left * solution[1] ** 2
    measured = np.isfinite(spreads)
    if not np.any(measured):
        return SectionOffsets(offsets, spreads, 0.0, 0)
    polarity = 1 if np.median(contrasts[measured]) > 0.0 else -1
    contrasts *= polarity
    weak = measured & (contrasts < _CONTRAST_MIN * np.median(contrasts[measured]))
    spreads[weak] = np.inf
    noise = max(np.sqrt(np.nanmedian(rests)), _ROUNDING)
    step = np.sum(blurs[~weak]) / max(np.sum(blur_weights[~weak]), 1e-9)
    offsets = np.minimum(np.maximum(offsets, -_OFFSET_MAX), _OFFSET_MAX)
    return SectionOffsets(offsets, noise * spreads, step, polarity)


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
