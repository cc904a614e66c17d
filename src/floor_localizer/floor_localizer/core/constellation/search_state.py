"""State of a search: best pose and runner-up; scoring of a hypothesis on the whole view."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray

from floor_localizer.core.acceptance import log_chance_alignments
from floor_localizer.core.constellation.alignment import match_closely, match_view
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.view_dots import ViewDots

LOOKS_SAME = 0.8
"""A runner-up with at least this fraction of the best pose's matches makes the pose ambiguous."""

# Margin on the scale tolerance for the error of the fitted scale.
_SCALE_MARGIN = 1.3
# Above this number of matches, their extent is approximated by the bounding box.
_MANY = 40


class Search(NamedTuple):
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
    rival: NDArray[np.float64]
    counts: NDArray[np.int64]
    matches: NDArray[np.int64]
    residuals: NDArray[np.float64]
    dots_in_scope: float
    log_accept: float
    least_matches: float


def new_search(dots: int, dots_in_scope: float, accept_below: float, match_rate_min: float) -> Search:
    """Return the initial state of a search.

    Args:
        dots: number of dots in view.
        candidate_dots: number of map dots in the area of the search.
        max_chance: maximum number of expected chance alignments of an accepted pose.
        match_rate_min: minimum match rate of an accepted pose, as a fraction of the dots in view.
    """
    nothing = np.array([math.inf, 1.0, 0.0, 0.0, 0.0, 0.0])
    return Search(
        nothing,
        nothing.copy(),
        np.zeros(3, dtype=np.int64),
        np.empty(dots, dtype=np.int64),
        np.empty(dots),
        dots_in_scope,
        math.log(accept_below),
        match_rate_min * dots,
    )


@register_jitable
def is_accepted(search: Search, pose: NDArray[np.float64]) -> bool:
    """Return whether ``search.best`` or ``search.runner_up`` is significant."""
    return pose[0] < search.log_accept and pose[5] >= search.least_matches


@njit(cache=True)
def judge(grid: DotGrid, view: ViewDots, search: Search, a: complex, b: complex) -> bool:
    """Match the whole view under a hypothesis, update best pose and runner-up, and return whether the best is
    accepted.
    """
    search.counts[2] += 1
    pose = _weigh(view, search, match_view(grid, view, a, b, search.matches, search.residuals))
    if not is_accepted(search, pose):
        a, b = complex(pose[1], pose[2]), complex(pose[3], pose[4])
        closer = _weigh(view, search, match_closely(grid, view, a, b, search.matches, search.residuals))
        if closer[0] < pose[0]:
            pose = closer
    chance = pose[0]
    if chance < search.best[0]:
        if not _same_place(grid, view, pose, search.best):
            _copy(search.best, search.rival)
        _copy(pose, search.best)
    elif chance < search.rival[0] and not _same_place(grid, view, pose, search.best):
        _copy(pose, search.rival)
    return is_accepted(search, search.best)


@njit(cache=True)
def _copy(pose: NDArray[np.float64], target: NDArray[np.float64]) -> None:
    for k in range(len(pose)):
        target[k] = pose[k]


@njit(cache=True)
def _weigh(view: ViewDots, search: Search, match: tuple[int, complex, complex]) -> NDArray[np.float64]:
    """Return a match of the whole view, with the residuals in ``search``, in the form of ``search.best``."""
    matched, a, b = match
    chance = math.inf
    if matched >= 3 and abs(abs(a) - 1.0) <= _SCALE_MARGIN * view.scale_tolerance:
        chance = log_chance_alignments(
            search.residuals,
            0.5 * view.sigma,
            _widest(view, search.matches),
            search.dots_in_scope,
            view.density,
            view.scale_tolerance,
        )
    return np.array([chance, a.real, a.imag, b.real, b.imag, float(matched)])


@njit(cache=True)
def _same_place(grid: DotGrid, view: ViewDots, pose: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Return whether two poses put the view at the same position with the same yaw."""
    turn = complex(pose[1] - other[1], pose[2] - other[2])
    shift = turn * view.z[0] + complex(pose[3] - other[3], pose[4] - other[4])
    return abs(shift) < 0.5 * grid.cell and abs(turn) < 0.2


@njit(cache=True)
def _widest(view: ViewDots, matches: NDArray[np.int64]) -> float:
    """Return the largest distance between matched dots [m]; for many dots, the diagonal of their bounding box."""
    matched = view.points[matches >= 0]
    if len(matched) > _MANY:
        x, y = matched[:, 0], matched[:, 1]
        return math.hypot(np.max(x) - np.min(x), np.max(y) - np.min(y))
    squared = 0.0
    for k in range(len(matched)):
        for j in range(k):
            squared = max(
                squared, (matched[k, 0] - matched[j, 0]) ** 2 + (matched[k, 1] - matched[j, 1]) ** 2
            )
    return math.sqrt(squared)
