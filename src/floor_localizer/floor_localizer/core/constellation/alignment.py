"""Verify a pose hypothesis, from a few seed dots to the whole view, with a sequential probability ratio test.

A similarity transform of the plane (rotation, scale, translation) is a pair of complex numbers: view dot z maps to
``a * z + b``. Each matched dot refines the fit, so that dots farther away can be predicted.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot
from floor_localizer.core.constellation.view_dots import ViewDots

# Matching gate: maximum residual of a match [standard deviations].
GATE = 3.2
# Residual below which a match is almost surely correct [standard deviations].
_CLOSE = 2.0
# Maximum search radius [mean dot spacings]; beyond it, matches are random.
_FARTHEST = 0.25
# Probability that a dot matches under a correct hypothesis: halfway between the worst correct view and chance.
_SHARE_IF_RIGHT = 0.5
# Wald's sequential probability ratio test: reject the hypothesis below this log-likelihood ratio.
_LOG_HOPELESS = -math.log(10.0)
# Above the first, the whole view is matched; above the second, no more neighbours are tested.
_LOG_WORTHY = math.log(30.0)
_LOG_PLAIN = math.log(10000.0)


class MatchSums(NamedTuple):
    """Sums over matched dots from which their least-squares similarity is computed.

    Attributes:
        size: number of matched dots.
        z: sum of the view dots.
        m: sum of the map dots.
        zz: sum of squared magnitudes of the view dots.
        zm: sum of conj(view dot) * map dot.
    """

    number: float
    z: complex
    m: complex
    zz: float
    zm: complex


@njit(cache=True)
def no_matches() -> MatchSums:
    """Return the sums over no matches."""
    return MatchSums(0.0, complex(0.0, 0.0), complex(0.0, 0.0), 0.0, complex(0.0, 0.0))


@njit(cache=True)
def add_match(sums: MatchSums, z: complex, m: complex) -> MatchSums:
    """Return the sums with one more match of view dot ``z`` and map dot ``m``."""
    squared = z.real * z.real + z.imag * z.imag
    return MatchSums(sums.number + 1.0, sums.z + z, sums.m + m, sums.zz + squared, sums.zm + np.conj(z) * m)


@njit(cache=True)
def fit_similarity(sums: MatchSums) -> tuple[complex, complex, float]:
    """Return the least-squares similarity (a, b) of two or more matches and the scatter of their view dots [m^2]."""
    spread = sums.zz - (sums.z.real * sums.z.real + sums.z.imag * sums.z.imag) / sums.number
    a = (sums.zm - np.conj(sums.z) * sums.m / sums.number) / spread
    return a, (sums.m - a * sums.z) / sums.number, spread


@njit(cache=True)
def grow(
    grid: DotGrid, view: ViewDots, seeds: NDArray[np.int64], map_i: int, map_j: int
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
    sums = add_match(no_matches(), view.z[seeds[0]], complex(0.0, 0.0))
    sums = add_match(sums, view.z[seeds[1]], end)
    a, b, spread = fit_similarity(sums)
    slack = view.scale_tolerance + 2.0 * view.sigma * GATE / math.sqrt(2.0 * spread)
    if abs(abs(a) - 1.0) > slack:
        return False, a, b
    for seed in seeds[2:]:
        found, _ = _find(grid, view, sums, origin, view.z[seed])
        if found < 0:
            return False, a, b
        sums = add_match(sums, view.z[seed], _map_dot(grid, found) - origin)
    evidence, sums = _weigh_neighbours(grid, view, sums, origin, seeds)
    a, b, _ = fit_similarity(sums)
    return evidence > _LOG_WORTHY, a, b + origin


@njit(cache=True)
def _weigh_neighbours(
    grid: DotGrid, view: ViewDots, sums: MatchSums, origin: complex, seeds: NDArray[np.int64]
) -> tuple[float, MatchSums]:
    """Test the neighbours of the last seed, nearest first, until the hypothesis is rejected or certain.

    Returns:
        log-likelihood ratio of the hypothesis to chance, and the sums including the matched neighbours.
    """
    evidence = 0.0
    for k in view.nearest[seeds[-1]]:
        if contains(seeds, k):
            continue
        found, reach = _find(grid, view, sums, origin, view.z[k])
        chance = view.density * math.pi * reach * reach
        if found >= 0:
            evidence += math.log(_SHARE_IF_RIGHT / chance)
            sums = add_match(sums, view.z[k], _map_dot(grid, found) - origin)
        else:
            evidence += math.log((1.0 - _SHARE_IF_RIGHT) / (1.0 - chance))
        if evidence < _LOG_HOPELESS or evidence > _LOG_PLAIN:
            break
    return evidence, sums


@njit(cache=True)
def _find(grid: DotGrid, view: ViewDots, sums: MatchSums, origin: complex, z: complex) -> tuple[int, float]:
    """Return the map dot nearest to the predicted position of a view dot, or -1, and the search radius [m]."""
    a, b, spread = fit_similarity(sums)
    off = z - sums.z / sums.number
    squared = off.real * off.real + off.imag * off.imag
    reach = GATE * view.sigma * math.sqrt(1.0 + 1.0 / sums.number + squared / spread) + view.bend * squared
    reach = min(reach, _FARTHEST * grid.cell)
    place = a * z + b + origin
    return nearest_dot(grid, place.real, place.imag, reach)[0], reach


@njit(cache=True)
def _map_dot(grid: DotGrid, i: int) -> complex:
    return complex(grid.points[i, 0], grid.points[i, 1])


@njit(cache=True)
def contains(dots: NDArray[np.int64], dot: int) -> bool:
    """Return whether a dot is in an array of dots."""
    for other in dots:  # noqa: SIM110 - numba compiles no any() over a generator
        if other == dot:
            return True
    return False


@njit(cache=True)
def match_view(
    grid: DotGrid,
    view: ViewDots,
    a: complex,
    b: complex,
    matches: NDArray[np.int64],
    residuals: NDArray[np.float64],
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
    reach = GATE * view.sigma * 1.3
    spread_all = 0.0
    middle = np.mean(view.z)
    for z in view.z:
        spread_all += abs(z - middle) ** 2
    largest = math.sqrt(spread_all / max(len(view.z), 1)) * 1.6
    reach = min(reach + view.bend * largest * largest * 0.5, 0.45 * grid.cell)
    previous = -1
    matched = 0
    for _ in range(6):
        matched = _match_once(grid, view, a, b, reach, matches, residuals)
        if matched < 3:
            return matched, a, b
        a, b = _fit(grid, view, matches)
        if matched == previous:
            break
        previous = matched
    return matched, a, b


@njit(cache=True)
def match_closely(
    grid: DotGrid,
    view: ViewDots,
    a: complex,
    b: complex,
    matches: NDArray[np.int64],
    residuals: NDArray[np.float64],
) -> tuple[int, complex, complex]:
    """Fit to the closest matches only, then match all dots again; arguments and results as in `match_view`.

    In a view of few dots, a single outlier biases the fit so much that the inliers look random.
    """
    if _match_once(grid, view, a, b, _CLOSE * view.sigma, matches, residuals) < 3:
        return 0, a, b
    a, b = _fit(grid, view, matches)
    return _match_once(grid, view, a, b, GATE * view.sigma, matches, residuals), a, b


@njit(cache=True)
def _match_once(
    grid: DotGrid,
    view: ViewDots,
    a: complex,
    b: complex,
    reach: float,
    matches: NDArray[np.int64],
    residuals: NDArray[np.float64],
) -> int:
    matched = 0
    for k in range(len(view.z)):
        place = a * view.z[k] + b
        found, squared = nearest_dot(grid, place.real, place.imag, reach)
        matches[k] = found
        residuals[k] = math.sqrt(squared) if found >= 0 else math.inf
        matched += found >= 0
    return matched


@njit(cache=True)
def _fit(grid: DotGrid, view: ViewDots, matches: NDArray[np.int64]) -> tuple[complex, complex]:
    """Return the least-squares similarity (a, b) of all matched dots."""
    origin = complex(0.0, 0.0)
    sums = no_matches()
    for k in range(len(matches)):
        if matches[k] < 0:
            continue
        if sums.number == 0.0:
            origin = _map_dot(grid, matches[k])
        sums = add_match(sums, view.z[k], _map_dot(grid, matches[k]) - origin)
    a, b, _ = fit_similarity(sums)
    return a, b + origin
