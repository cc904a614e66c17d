"""Grow a guess from a few dots to the whole view, or drop it as soon as it is hopeless.

A similarity (turn, scale, shift) of the plane is a pair of complex numbers: a view dot z lies at ``a * z +
b`` on the map. With every dot that is found where it should be, the fit over all of them gets better and
reaches farther.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.constellation.dot_grid import DotGrid, nearest_dot

# A dot is looked for within this many standard deviations of where it should be.
GATE = 3.2
# Share of a view's dots that a right guess finds at least: the middle between the worst right view and
# chance.
_SHARE_IF_RIGHT = 0.5
# A guess is dropped when the dots tried so far are this many times likelier by chance (Wald's sequential
# test).
_LOG_HOPELESS = -math.log(10.0)
# It is worth a look at the whole view when they are this many times likelier by truth, and tried no further
# beyond.
_LOG_WORTHY = math.log(30.0)
_LOG_PLAIN = math.log(10000.0)


class ViewDots(NamedTuple):
    """The dots of one view, made ready for the search.

    Attributes:
        points: shape (n, 2), where the dots lie on the floor in the base frame, for the camera as mounted
            [m].
        z: shape (n,) complex, the same.
        nearest: shape (n, m), for each dot the others from near to far.
        sigma: standard deviation of a dot's place along each axis, in the image and in the map together [m].
        bend: shift of a dot by tilt, over the square of its distance from the dots fitted so far [1/m].
        scale_tolerance: the camera's height may be off by this share.
        density: dots of the map on a square metre where there are dots [1/m^2].
    """

    points: NDArray[np.float64]
    z: NDArray[np.complex128]
    nearest: NDArray[np.int64]
    sigma: float
    bend: float
    scale_tolerance: float
    density: float


@njit(cache=True)
def order_neighbours(points: NDArray[np.float64], most: int) -> NDArray[np.int64]:
    """Return for each dot the indices of up to ``most`` others from near to far, shape (n, m)."""
    n = len(points)
    m = min(n - 1, most)
    nearest = np.empty((n, max(m, 0)), dtype=np.int64)
    squared = np.empty(n)
    for i in range(n):
        for j in range(n):
            dx = points[i, 0] - points[j, 0]
            dy = points[i, 1] - points[j, 1]
            squared[j] = dx * dx + dy * dy
        squared[i] = -1.0
        nearest[i] = np.argsort(squared)[1 : m + 1]
    return nearest


@njit(cache=True)
def similarity_of_sums(
    count: float, sum_z: complex, sum_m: complex, sum_zz: float, sum_zm: complex
) -> tuple[complex, complex, float]:
    """Return the least-squares similarity (a, b) of matched dots and the spread of the view dots [m^2].

    Args:
        count: number of matched dots.
        sum_z: sum of the view dots.
        sum_m: sum of the map dots.
        sum_zz: sum of squared magnitudes of the view dots.
        sum_zm: sum of conj(view dot) * map dot.
    """
    spread = sum_zz - (sum_z.real * sum_z.real + sum_z.imag * sum_z.imag) / count
    a = (sum_zm - np.conj(sum_z) * sum_m / count) / spread
    return a, (sum_m - a * sum_z) / count, spread


@njit(cache=True)
def grow(
    grid: DotGrid, view: ViewDots, seeds: NDArray[np.int64], map_i: int, map_j: int
) -> tuple[bool, complex, complex]:
    """Grow the guess that the first two seeds are map_i and map_j through the neighbours of the last seed.

    Args:
        grid: the map.
        view: the dots in view.
        seeds: shape (s,), s >= 2, view dots; those after the first two must be found on the map, and as they
            made the guess they are no evidence for it.
        map_i: map dot of the first seed.
        map_j: map dot of the second.

    Returns:
        whether the guess is worth a look at the whole view, and its similarity (a, b).
    """
    origin = complex(grid.points[map_i, 0], grid.points[map_i, 1])
    end = complex(grid.points[map_j, 0], grid.points[map_j, 1]) - origin
    zi, zj = view.z[seeds[0]], view.z[seeds[1]]
    count = 2.0
    sum_z, sum_m = zi + zj, end
    sum_zz = zi.real * zi.real + zi.imag * zi.imag + zj.real * zj.real + zj.imag * zj.imag
    sum_zm = np.conj(zj) * end
    a, b, spread = similarity_of_sums(count, sum_z, sum_m, sum_zz, sum_zm)
    slack = view.scale_tolerance + 2.0 * view.sigma * GATE / math.sqrt(2.0 * spread)
    if abs(abs(a) - 1.0) > slack:
        return False, a, b
    evidence = 0.0
    pivot = seeds[-1]
    for m in range(2 - len(seeds), view.nearest.shape[1]):
        k = seeds[len(seeds) + m] if m < 0 else view.nearest[pivot, m]
        if m >= 0 and _contains(seeds, k):
            continue
        z = view.z[k]
        off = z - sum_z / count
        squared = off.real * off.real + off.imag * off.imag
        reach = GATE * view.sigma * math.sqrt(1.0 + 1.0 / count + squared / spread) + view.bend * squared
        reach = min(reach, 0.25 * grid.cell)
        place = a * z + b + origin
        found, _ = nearest_dot(grid, place.real, place.imag, reach)
        if m < 0 and found < 0:
            return False, a, b
        if m >= 0:
            chance = view.density * math.pi * reach * reach
            if found < 0:
                evidence += math.log((1.0 - _SHARE_IF_RIGHT) / (1.0 - chance))
                if evidence < _LOG_HOPELESS:
                    return False, a, b
                continue
            evidence += math.log(_SHARE_IF_RIGHT / chance)
        dot = complex(grid.points[found, 0], grid.points[found, 1]) - origin
        count += 1.0
        sum_z += z
        sum_m += dot
        sum_zz += z.real * z.real + z.imag * z.imag
        sum_zm += np.conj(z) * dot
        a, b, spread = similarity_of_sums(count, sum_z, sum_m, sum_zz, sum_zm)
        if evidence > _LOG_PLAIN:
            break
    return evidence > _LOG_WORTHY, a, b + origin


@njit(cache=True)
def _contains(seeds: NDArray[np.int64], dot: int) -> bool:
    """Tell whether a dot is one of the seeds."""
    for seed in seeds:  # noqa: SIM110 (the compiler knows no generators)
        if seed == dot:
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
    """Match all dots of a view under a guess and fit the similarity to them, until the matches stay.

    Args:
        grid: the map.
        view: the dots in view.
        a: turn and scale of the guess.
        b: its shift [m].
        matches: shape (n,), written: the index of each dot's map dot in the grid, or -1.
        residuals: shape (n,), written: its distance from there [m], infinite where there is none.

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
        a, b = _fit(grid, view, matches, matched)
        if matched == previous:
            break
        previous = matched
    return matched, a, b


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
def _fit(grid: DotGrid, view: ViewDots, matches: NDArray[np.int64], matched: int) -> tuple[complex, complex]:
    """Return the least-squares similarity over all matched dots."""
    origin = complex(0.0, 0.0)
    sum_z, sum_m, sum_zm = complex(0.0, 0.0), complex(0.0, 0.0), complex(0.0, 0.0)
    sum_zz = 0.0
    first = True
    for k in range(len(matches)):
        if matches[k] < 0:
            continue
        dot = complex(grid.points[matches[k], 0], grid.points[matches[k], 1])
        if first:
            origin = dot
            first = False
        dot -= origin
        z = view.z[k]
        sum_z += z
        sum_m += dot
        sum_zz += z.real * z.real + z.imag * z.imag
        sum_zm += np.conj(z) * dot
    a, b, _ = similarity_of_sums(float(matched), sum_z, sum_m, sum_zz, sum_zm)
    return a, b + origin
