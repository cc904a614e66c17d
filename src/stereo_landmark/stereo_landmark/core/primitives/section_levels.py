"""Grey levels along a straight side: where they change evenly, sections learn them from each other.

A section alone knows its two levels from some ten pixels each, and does not know its offset better than them. Along a
side levels mostly change evenly, and how far they leave a line shows how much a section may learn from the others
(empirical Bayes): under even light nearly all, at a shadow or a grain nothing.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

_SECTIONS_MIN = 4
# A section this many deviations off the line shows something else and learns nothing.
_APART = 3.5
_ROUNDS = 3
_MAD_TO_SIGMA = 1.4826
# Levels are never known better from other sections than to this part of the contrast.
_GRAIN = 0.002


@njit(cache=True, error_model='numpy')
def pull_levels(
    normal: NDArray[np.float64],
    right: NDArray[np.float64],
    squares: NDArray[np.float64],
    solutions: NDArray[np.float64],
    inverses: NDArray[np.float64],
    rests: NDArray[np.float64],
    noise: float,
) -> None:
    """Add to the normal equations of sections what the others say of their levels.

    Args:
        normal: shape (k, 4, 4), the first unknown is the level outside, the second the contrast.
        right: shape (k, 4).
        squares: shape (k,), of the observed values.
        solutions: shape (k, 3), of the sections alone.
        inverses: shape (k, 3, 3), of their normal matrices.
        rests: shape (k,), not a number where a section could not be solved.
        noise: standard deviation of a pixel [grey levels].
    """
    solved = np.flatnonzero(~np.isnan(rests))
    if len(solved) < _SECTIONS_MIN:
        return
    contrast = np.median(np.abs(solutions[solved, 1]))
    levels, variances, expected = np.empty(len(solved)), np.empty(len(solved)), np.empty(len(solved))
    for inside in range(2):
        for m in range(len(solved)):
            k = solved[m]
            levels[m] = solutions[k, 0] + inside * solutions[k, 1]
            spread = inverses[k, 0, 0] + inside * (2.0 * inverses[k, 0, 1] + inverses[k, 1, 1])
            variances[m] = noise**2 * spread
        scatter = _even_change(solved, len(rests), levels, variances, expected)
        if scatter < 0.0:
            continue
        for m in range(len(solved)):
            off = levels[m] - expected[m]
            if off * off > _APART**2 * (variances[m] + scatter):
                continue
            k, weight = solved[m], noise**2 / (scatter + (_GRAIN * contrast) ** 2)
            for r in range(1 + inside):
                right[k, r] += weight * expected[m]
                for c in range(1 + inside):
                    normal[k, r, c] += weight
            squares[k] += weight * expected[m] ** 2


@njit(cache=True, error_model='numpy')
def _even_change(
    numbers: NDArray[np.int64],
    count: int,
    levels: NDArray[np.float64],
    variances: NDArray[np.float64],
    expected: NDArray[np.float64],
) -> float:
    """Write the levels on a line through those of most sections, and return by which variance they leave it.

    Args:
        numbers: shape (n,), of the sections along the side.
        count: of all sections.
        levels: shape (n,), measured.
        variances: shape (n,), by the noise of the image.
        expected: shape (n,), to be filled.

    Returns:
        what noise does not explain; negative where too few sections agree.
    """
    expected[:] = np.median(levels)
    scatter = (_MAD_TO_SIGMA * np.median(np.abs(levels - expected))) ** 2
    for _ in range(_ROUNDS):
        sums, kept = np.zeros(5), 0
        for m in range(len(levels)):
            if (levels[m] - expected[m]) ** 2 > _APART**2 * (variances[m] + scatter):
                continue
            weight, place = 1.0 / (variances[m] + scatter), (numbers[m] + 0.5) / count - 0.5
            kept += 1
            for power in range(3):
                sums[power] += weight * place**power
            sums[3] += weight * levels[m]
            sums[4] += weight * place * levels[m]
        determinant = sums[0] * sums[2] - sums[1] ** 2
        if kept < _SECTIONS_MIN or determinant <= 0.0:
            return -1.0
        slope = (sums[0] * sums[4] - sums[1] * sums[3]) / determinant
        middle = (sums[3] - slope * sums[1]) / sums[0]
        more, freedom = 0.0, kept - 2.0
        for m in range(len(levels)):
            off = levels[m] - expected[m]
            is_kept = off * off <= _APART**2 * (variances[m] + scatter)
            expected[m] = middle + slope * ((numbers[m] + 0.5) / count - 0.5)
            if is_kept:
                more += (levels[m] - expected[m]) ** 2 - variances[m] * freedom / kept
        scatter = max(more / freedom, 0.0)
    return scatter
