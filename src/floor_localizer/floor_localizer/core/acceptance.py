"""Significance of a match: the expected number of chance alignments, from the map's density and size.

This is the number of false alarms (NFA) of an a-contrario test (Moisan & Stival, "A probabilistic criterion to
detect rigid point matches between two images", 2004), here for a view of a floor. Two view dots match every pair of
map dots of the same length, up to the scale tolerance; each such pair is one pose. Under a pose, another view dot has
a map dot within r by chance with p = density * pi * r^2. Any two of k matched dots may be the pair, and k may be any
of 3..n, so

    E(k, r) = N density 2 pi d (2 s d + 4 r) * (n - 2) C(n, k) C(k, 2) * p(r)^(k - 2)

bounds the expected number of poses on the whole map that match k of n view dots within r by chance. N is the number
of map dots, d the largest distance between matched dots, s the relative scale tolerance, and r the largest residual
of the k matches. The result is the smallest E over k. It has no parameter that is tuned to a floor.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def log_chance_alignments(
    residuals: NDArray[np.float64],
    smallest_residual: float,
    distance: float,
    dots_in_map: float,
    density: float,
    scale_tolerance: float,
) -> float:
    """Return the logarithm of the expected number of chance alignments as good as this match, infinite without a match.

    Args:
        residuals: shape (n,), distance of each view dot from its map dot [m], infinite without a match.
        smallest_residual: lower limit of the residuals, the accuracy of map and model [m].
        distance: largest distance between matched view dots [m].
        dots_in_map: number of map dots in the area of the search.
        density: density of the map's dots on the occupied floor [1/m^2].
        scale_tolerance: maximum relative error of the scale.
    """
    ordered = np.sort(residuals)
    n = len(ordered)
    best = 0.0
    log_choose = math.log(n * (n - 1) / 2.0) if n > 1 else 0.0
    for k in range(3, n + 1):
        log_choose += math.log((n - k + 1) / k)
        if not math.isfinite(ordered[k - 1]):
            break
        r = max(ordered[k - 1], smallest_residual)
        chance = min(density * math.pi * r * r, 1.0)
        pairs = density * 2.0 * math.pi * distance * (2.0 * scale_tolerance * distance + 4.0 * r)
        log_tests = (
            math.log(max(dots_in_map * pairs, 1.0)) + math.log((n - 2) * k * (k - 1) / 2.0) + log_choose
        )
        log_expected = log_tests + (k - 2) * math.log(chance)
        if k == 3 or log_expected < best:
            best = log_expected
    if n < 3 or not math.isfinite(ordered[2]):
        return math.inf
    return best
