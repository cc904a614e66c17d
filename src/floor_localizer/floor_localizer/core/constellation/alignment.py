"""Verify a pose hypothesis, from a few seed dots to the whole view, with a sequential probability ratio test.

A similarity transform of the plane (rotation, scale, translation) is a pair of complex numbers: view dot z maps to
``a * z + b``. Each matched dot refines the fit, so that dots farther away can be predicted.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot
from floor_localizer.core.dots import ViewDots

# Matching gate: maximum residual of a match [standard deviations].
GATE = 3.2
# Residual below which a match is almost surely correct [standard deviations].
_INLIER_GATE = 2.0
# Maximum search radius [mean dot spacings]; beyond it, matches are random.
_MAX_RADIUS = 0.25
# Probability that a dot matches under a correct hypothesis: halfway between the worst correct view and chance.
_MATCH_PROBABILITY = 0.5
# Wald's sequential probability ratio test: reject the hypothesis below this log-likelihood ratio.
_LOG_REJECT = -math.log(10.0)
# Above the first, the whole view is matched; above the second, no more neighbours are tested.
_LOG_ACCEPT = math.log(30.0)
_LOG_CERTAIN = math.log(10000.0)


class MatchSums(NamedTuple):
    """Sums over matched dots from which their least-squares similarity is computed.

    Attributes:
        size: number of matched dots.
        z: sum of the view dots.
        m: sum of the map dots.
        zz: sum of squared magnitudes of the view dots.
        zm: sum of conj(view dot) * map dot.
    """

    size: float
    z: complex
    m: complex
    zz: float
    zm: complex


@njit(cache=True)
def empty_sums() -> MatchSums:
    """Return the sums over no matches."""
    return MatchSums(0.0, complex(0.0, 0.0), complex(0.0, 0.0), 0.0, complex(0.0, 0.0))


@njit(cache=True)
def add_match(sums: MatchSums, z: complex, m: complex) -> MatchSums:
    """Return the sums with one more match of view dot ``z`` and map dot ``m``."""
    squared = z.real * z.real + z.imag * z.imag
    return MatchSums(sums.size + 1.0, sums.z + z, sums.m + m, sums.zz + squared, sums.zm + np.conj(z) * m)


@njit(cache=True)
def fit_similarity(sums: MatchSums) -> tuple[complex, complex, float]:
    """Return the least-squares similarity (a, b) of two or more matches and the scatter of their view dots [m^2]."""
    spread = sums.zz - (sums.z.real * sums.z.real + sums.z.imag * sums.z.imag) / sums.size
    a = (sums.zm - np.conj(sums.z) * sums.m / sums.size) / spread
    return a, (sums.m - a * sums.z) / sums.size, spread


@njit(cache=True)
def verify_hypothesis(
    grid: DotGrid, view: ViewDots, seeds: Ints, map_i: int, map_j: int
) -> tuple[bool, complex, complex]:
    """Verify the hypothesis that the first two seeds are two map dots, on the neighbours of the last seed.

    Args:
        grid: the map.
        view: the view.
        seeds: shape (s,), s >= 2, view dots; those after the first two must match the map. They generated the
            hypothesis and therefore do not count in the likelihood ratio.
        map_i: map dot of the first seed.
        map_j: map dot of the second seed.

    Returns:
        whether the hypothesis is likely enough to match the whole view, and its similarity (a, b).
    """
    # Sums relative to a map dot keep their precision far from the map's origin.
    origin = complex(grid.points[map_i, 0], grid.points[map_i, 1])
    end = complex(grid.points[map_j, 0], grid.points[map_j, 1]) - origin
    sums = add_match(empty_sums(), view.z[seeds[0]], complex(0.0, 0.0))
    sums = add_match(sums, view.z[seeds[1]], end)
    a, b, spread = fit_similarity(sums)
    scale_gate = view.scale_tolerance + 2.0 * view.sigma * GATE / math.sqrt(2.0 * spread)
    if abs(abs(a) - 1.0) > scale_gate:
        return False, a, b
    for seed in seeds[2:]:
        found, _ = _find_match(grid, view, sums, origin, view.z[seed])
        if found < 0:
            return False, a, b
        sums = add_match(sums, view.z[seed], _map_point(grid, found) - origin)
    log_likelihood_ratio, sums = _test_neighbours(grid, view, sums, origin, seeds)
    a, b, _ = fit_similarity(sums)
    return log_likelihood_ratio > _LOG_ACCEPT, a, b + origin


@njit(cache=True)
def _test_neighbours(
    grid: DotGrid, view: ViewDots, sums: MatchSums, origin: complex, seeds: Ints
) -> tuple[float, MatchSums]:
    """Test the neighbours of the last seed, nearest first, until the hypothesis is rejected or certain.

    Returns:
        log-likelihood ratio of the hypothesis to chance, and the sums including the matched neighbours.
    """
    log_likelihood_ratio = 0.0
    for k in view.neighbours[seeds[-1]]:
        if contains(seeds, k):
            continue
        found, radius = _find_match(grid, view, sums, origin, view.z[k])
        chance = view.density * math.pi * radius * radius
        if found >= 0:
            log_likelihood_ratio += math.log(_MATCH_PROBABILITY / chance)
            sums = add_match(sums, view.z[k], _map_point(grid, found) - origin)
        else:
            log_likelihood_ratio += math.log((1.0 - _MATCH_PROBABILITY) / (1.0 - chance))
        if log_likelihood_ratio < _LOG_REJECT or log_likelihood_ratio > _LOG_CERTAIN:
            break
    return log_likelihood_ratio, sums


@njit(cache=True)
def _find_match(grid: DotGrid, view: ViewDots, sums: MatchSums, origin: complex, z: complex) -> tuple[int, float]:
    """Return the map dot nearest to the predicted position of a view dot, or -1, and the search radius [m]."""
    a, b, spread = fit_similarity(sums)
    offset = z - sums.z / sums.size
    squared = offset.real * offset.real + offset.imag * offset.imag
    radius = GATE * view.sigma * math.sqrt(1.0 + 1.0 / sums.size + squared / spread) + view.tilt_distortion * squared
    radius = min(radius, _MAX_RADIUS * grid.cell)
    position = a * z + b + origin
    return nearest_dot(grid, position.real, position.imag, radius)[0], radius


@njit(cache=True)
def _map_point(grid: DotGrid, i: int) -> complex:
    return complex(grid.points[i, 0], grid.points[i, 1])


@njit(cache=True)
def contains(dots: Ints, dot: int) -> bool:
    """Return whether a dot is in an array of dots."""
    for other in dots:  # noqa: SIM110 - numba compiles no any() over a generator
        if other == dot:
            return True
    return False


@njit(cache=True)
def match_view(
    grid: DotGrid, view: ViewDots, a: complex, b: complex, matches: Ints, residuals: Floats
) -> tuple[int, complex, complex]:
    """Match all dots of a view under a hypothesis and refit the similarity, until the matches converge.

    Args:
        grid: the map.
        view: the view.
        a: rotation and scale of the hypothesis.
        b: translation of the hypothesis [m].
        matches: shape (n,), output: index of each dot's map dot in the grid, or -1.
        residuals: shape (n,), output: distance of each dot from its map dot [m], infinite without a match.

    Returns:
        the number of matches and the similarity (a, b) fitted to them.
    """
    radius = GATE * view.sigma * 1.3
    squared_extent = 0.0
    centroid = np.mean(view.z)
    for z in view.z:
        squared_extent += abs(z - centroid) ** 2
    extent = math.sqrt(squared_extent / max(len(view.z), 1)) * 1.6
    radius = min(radius + view.tilt_distortion * extent * extent * 0.5, 0.45 * grid.cell)
    previous = -1
    matched = 0
    for _ in range(6):
        matched = _match_nearest(grid, view, a, b, radius, matches, residuals)
        if matched < 3:
            return matched, a, b
        a, b = _fit_matches(grid, view, matches)
        if matched == previous:
            break
        previous = matched
    return matched, a, b


@njit(cache=True)
def match_view_robustly(
    grid: DotGrid, view: ViewDots, a: complex, b: complex, matches: Ints, residuals: Floats
) -> tuple[int, complex, complex]:
    """Fit to the closest matches only, then match all dots again; arguments and results as in `match_view`.

    In a view of few dots, a single outlier biases the fit so much that the inliers look random.
    """
    if _match_nearest(grid, view, a, b, _INLIER_GATE * view.sigma, matches, residuals) < 3:
        return 0, a, b
    a, b = _fit_matches(grid, view, matches)
    return _match_nearest(grid, view, a, b, GATE * view.sigma, matches, residuals), a, b


@njit(cache=True)
def _match_nearest(
    grid: DotGrid, view: ViewDots, a: complex, b: complex, radius: float, matches: Ints, residuals: Floats
) -> int:
    matched = 0
    for k in range(len(view.z)):
        position = a * view.z[k] + b
        found, squared = nearest_dot(grid, position.real, position.imag, radius)
        matches[k] = found
        residuals[k] = math.sqrt(squared) if found >= 0 else math.inf
        matched += found >= 0
    return matched


@njit(cache=True)
def _fit_matches(grid: DotGrid, view: ViewDots, matches: Ints) -> tuple[complex, complex]:
    """Return the least-squares similarity (a, b) of all matched dots."""
    origin = complex(0.0, 0.0)
    sums = empty_sums()
    for k in range(len(matches)):
        if matches[k] < 0:
            continue
        if sums.size == 0.0:
            origin = _map_point(grid, matches[k])
        sums = add_match(sums, view.z[k], _map_point(grid, matches[k]) - origin)
    a, b, _ = fit_similarity(sums)
    return a, b + origin
