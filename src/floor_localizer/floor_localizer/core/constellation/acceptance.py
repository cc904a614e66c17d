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
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray

from floor_localizer.core.constellation.alignment import match_view, match_view_robustly
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.view_dots import ViewDots


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


AMBIGUITY_FRACTION = 0.8
"""A runner-up with at least this fraction of the best pose's matches makes the pose ambiguous."""

# Margin on the scale tolerance for the error of the fitted scale.
_SCALE_MARGIN = 1.3
# Above this number of matches, their extent is approximated by the bounding box.
_MANY_MATCHES = 40


class SearchState(NamedTuple):
    """State of a search, shared by its steps.

    Attributes:
        best: shape (6,), best pose: logarithm of the expected chance alignments, a.real, a.imag, b.real, b.imag,
            number of matched dots.
        runner_up: shape (6,), the same for the best pose at another place.
        counts: shape (3,): index cells opened, hypotheses verified, hypotheses scored on the whole view.
        matches: shape (n,), buffer for the matches of a hypothesis.
        residuals: shape (n,), buffer for the residuals of a hypothesis [m].
        candidate_dots: number of map dots in the area of the search.
        log_threshold: maximum logarithm of the expected chance alignments of an accepted pose.
        min_matches: minimum number of matched dots of an accepted pose.
    """

    best: NDArray[np.float64]
    runner_up: NDArray[np.float64]
    counts: NDArray[np.int64]
    matches: NDArray[np.int64]
    residuals: NDArray[np.float64]
    candidate_dots: float
    log_threshold: float
    min_matches: float


def new_search(dots: int, candidate_dots: float, max_chance: float, match_rate_min: float) -> SearchState:
    """Return the initial state of a search.

    Args:
        dots: number of dots in view.
        candidate_dots: number of map dots in the area of the search.
        max_chance: maximum number of expected chance alignments of an accepted pose.
        match_rate_min: minimum match rate of an accepted pose, as a fraction of the dots in view.
    """
    no_pose = np.array([math.inf, 1.0, 0.0, 0.0, 0.0, 0.0])
    return SearchState(
        no_pose,
        no_pose.copy(),
        np.zeros(3, dtype=np.int64),
        np.empty(dots, dtype=np.int64),
        np.empty(dots),
        candidate_dots,
        math.log(max_chance),
        match_rate_min * dots,
    )


@register_jitable
def is_accepted(search: SearchState, pose: NDArray[np.float64]) -> bool:
    """Return whether ``search.best`` or ``search.runner_up`` is significant."""
    return pose[0] < search.log_threshold and pose[5] >= search.min_matches


@njit(cache=True)
def score_hypothesis(grid: DotGrid, view: ViewDots, search: SearchState, a: complex, b: complex) -> bool:
    """Match the whole view under a hypothesis, update best pose and runner-up, and return whether the best is
    accepted.
    """
    search.counts[2] += 1
    pose = _score_match(view, search, match_view(grid, view, a, b, search.matches, search.residuals))
    if not is_accepted(search, pose):
        a, b = complex(pose[1], pose[2]), complex(pose[3], pose[4])
        robust = _score_match(
            view, search, match_view_robustly(grid, view, a, b, search.matches, search.residuals)
        )
        if robust[0] < pose[0]:
            pose = robust
    log_chance = pose[0]
    if log_chance < search.best[0]:
        if not _is_same_pose(grid, view, pose, search.best):
            _copy(search.best, search.runner_up)
        _copy(pose, search.best)
    elif log_chance < search.runner_up[0] and not _is_same_pose(grid, view, pose, search.best):
        _copy(pose, search.runner_up)
    return is_accepted(search, search.best)


@njit(cache=True)
def _copy(pose: NDArray[np.float64], target: NDArray[np.float64]) -> None:
    for k in range(len(pose)):
        target[k] = pose[k]


@njit(cache=True)
def _score_match(
    view: ViewDots, search: SearchState, match: tuple[int, complex, complex]
) -> NDArray[np.float64]:
    """Return a match of the whole view, with the residuals in ``search``, in the form of ``search.best``."""
    matched, a, b = match
    log_chance = math.inf
    if matched >= 3 and abs(abs(a) - 1.0) <= _SCALE_MARGIN * view.scale_tolerance:
        log_chance = log_chance_alignments(
            search.residuals,
            0.5 * view.sigma,
            _match_extent(view, search.matches),
            search.candidate_dots,
            view.density,
            view.scale_tolerance,
        )
    return np.array([log_chance, a.real, a.imag, b.real, b.imag, float(matched)])


@njit(cache=True)
def _is_same_pose(
    grid: DotGrid, view: ViewDots, pose: NDArray[np.float64], other: NDArray[np.float64]
) -> bool:
    """Return whether two poses put the view at the same position with the same yaw."""
    turn = complex(pose[1] - other[1], pose[2] - other[2])
    shift = turn * view.z[0] + complex(pose[3] - other[3], pose[4] - other[4])
    return abs(shift) < 0.5 * grid.cell and abs(turn) < 0.2


@njit(cache=True)
def _match_extent(view: ViewDots, matches: NDArray[np.int64]) -> float:
    """Return the largest distance between matched dots [m]; for many dots, the diagonal of their bounding box."""
    matched = view.points[matches >= 0]
    if len(matched) > _MANY_MATCHES:
        x, y = matched[:, 0], matched[:, 1]
        return math.hypot(np.max(x) - np.min(x), np.max(y) - np.min(y))
    squared = 0.0
    for k in range(len(matched)):
        for j in range(k):
            squared = max(
                squared, (matched[k, 0] - matched[j, 0]) ** 2 + (matched[k, 1] - matched[j, 1]) ** 2
            )
    return math.sqrt(squared)
