"""When a match is more than chance: the expected number of chance alignments, from the map's density and
size.

An a-contrario test (Moisan & Stival, "A probabilistic criterion to detect rigid point matches between two
images", 2004), here for a view of a floor. Two view dots can be laid on every pair of map dots that is as far
apart, up to the tolerance of the scale; each such pair is one pose. Under a pose, another view dot has a map
dot within r of it by chance with p = density * pi * r^2. Any two of k matched dots may be the pair, and k may
be any of 3..n, so

    E(k, r) = N density 2 pi d (2 s d + 4 r) * (n - 2) C(n, k) C(k, 2) * p(r)^(k - 2)

bounds how many poses of the whole map are expected to match k of n view dots within r by chance, where N is
the number of map dots, d the distance of the two farthest matched dots and s the share by which the scale may
be off. r is the largest residual of the k. The smallest E over k is the evidence of a match: no number in it
is tuned to a floor.
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
    """Return the logarithm of how many poses as good as this one are expected by chance, infinite without a
    match.

    Args:
        residuals: shape (n,), distance of each view dot from its map dot [m], infinite where there is none.
        smallest_residual: residuals below this are no evidence: the accuracy of map and model [m].
        distance: between the two farthest matched view dots [m].
        dots_in_map: number of map dots where the pose may be.
        density: of the map where there are dots [1/m^2].
        scale_tolerance: share by which the scale may be off.
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
