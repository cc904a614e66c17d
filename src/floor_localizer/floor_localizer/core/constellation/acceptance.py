"""Score a hypothesis on the whole view: significance of its match, best pose and runner-up.

The significance is the number of false alarms (NFA) of an a-contrario test (Moisan & Stival, "A probabilistic criterion
to detect rigid point matches between two images", 2004), with the sum of squared residuals of the matches in place of
their largest residual. If k view dots were matched to k random map dots, the positions of these (2k coordinates) would
have to be within S of a similarity of the view dots: 2k - 4 coordinates in a ball of radius sqrt(S), and four for
translation, heading and scale. So

    E(k, S) = (n - 2) C(n, k) * N density 4 pi s k V * (pi density S)^(k - 2) / (k - 2)!

is the expected number of similarities on the whole map that match k of n view dots this well by chance. N is the number
of map dots, s the relative scale tolerance, S the sum of the squared residuals of the k closest matches, and V the sum
of the squared distances of these k view dots from their centroid. k may be any of 3..n, hence the factor n - 2. The
result is the smallest E over k. It has no parameter that is tuned to a floor. Because residuals are normal, S decides
between a right match and chance with more power than the largest residual.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.extending import register_jitable
from numpy.typing import NDArray

from floor_localizer.core.arrays import Complexes, Floats, Ints
from floor_localizer.core.constellation.alignment import match_view, match_view_robustly
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.dots import ViewDots
from shirube_core.geometry import SE2

AMBIGUITY_FRACTION = 0.8  # a runner-up with at least this fraction of the best pose's matches makes the pose ambiguous
# Margin on the scale tolerance for the error of the fitted scale.
_SCALE_MARGIN = 1.3
_POSE = np.dtype([('log_chance', np.float64), ('a', np.complex128), ('b', np.complex128), ('matched', np.float64)])
# Places of the poses of a search.
BEST, RUNNER_UP = 0, 1


@njit(cache=True)
def log_chance_alignments(
    residuals: Floats,
    z: Complexes,
    smallest_residual: float,
    dots_in_map: float,
    density: float,
    scale_tolerance: float,
) -> float:
    """Return the logarithm of the expected number of chance alignments as good as this match, infinite without a match.

    Args:
        residuals: shape (n,), distance of each view dot from its map dot [m], infinite without a match.
        z: shape (n,), the view dots [m].
        smallest_residual: lower limit of the residuals along each axis, the accuracy of map and model [m].
        dots_in_map: number of map dots in the area of the search.
        density: density of the map's dots on the occupied floor [1/m^2].
        scale_tolerance: maximum relative error of the scale.
    """
    n, best = len(residuals), math.inf
    log_choose = log_factorial = squares = spread = 0.0
    centroid = complex(0.0, 0.0)
    for index, dot in enumerate(np.argsort(residuals)):
        k = index + 1
        if not math.isfinite(residuals[dot]):
            break
        squares += residuals[dot] ** 2
        offset = z[dot] - centroid
        centroid += offset / k
        spread += (offset.real**2 + offset.imag**2) * index / k
        log_choose += math.log((n - index) / k)
        if k < 3:
            continue
        log_factorial += math.log(k - 2)
        freedom = 2.0 * (k - 2)
        ball = math.pi * density * max(squares, freedom * smallest_residual**2)
        similarities = dots_in_map * density * 4.0 * math.pi * scale_tolerance * k * spread
        log_tests = math.log(n - 2) + log_choose + math.log(max(similarities, 1.0))
        best = min(best, log_tests + (k - 2) * math.log(ball) - log_factorial)
    return best


class ScoredPose(NamedTuple):
    """A pose of a search, and how well the view matches the map there.

    Attributes:
        log_chance: logarithm of the expected chance alignments, infinite without a pose.
        a: complex rotation and scale; a view dot z is at ``a * z + b`` on the map.
        b: complex translation [m].
        matched: number of matched dots.
    """

    log_chance: float
    a: complex
    b: complex
    matched: float

    @property
    def pose(self) -> SE2:
        """The pose of the base in the map frame, without the scale."""
        return SE2(self.b.real, self.b.imag, math.atan2(self.a.imag, self.a.real))


class SearchState(NamedTuple):
    """State of a search, shared by its steps.

    Attributes:
        poses: shape (2,), records with the fields of `ScoredPose`: the best pose, and the best at another place.
        counts: shape (3,): index cells opened, hypotheses verified, hypotheses scored on the whole view.
        matches: shape (n,), buffer for the matches of a hypothesis.
        residuals: shape (n,), buffer for the residuals of a hypothesis [m].
        candidate_dots: number of map dots in the area of the search.
        log_threshold: maximum logarithm of the expected chance alignments of an accepted pose.
        min_matches: minimum number of matched dots of an accepted pose.
    """

    poses: NDArray[Any]
    counts: Ints
    matches: Ints
    residuals: Floats
    candidate_dots: float
    log_threshold: float
    min_matches: float

    @property
    def best(self) -> ScoredPose:
        """The best pose so far."""
        return ScoredPose(*self.poses[BEST].item())

    @property
    def runner_up(self) -> ScoredPose:
        """The best pose at another place."""
        return ScoredPose(*self.poses[RUNNER_UP].item())

    def plausible_poses(self) -> list[ScoredPose]:
        """Return the best pose, and the runner-up if it is about as good."""
        best, other = self.best, self.runner_up
        is_ambiguous = is_accepted(self, other) and other.matched >= AMBIGUITY_FRACTION * best.matched
        return [best, other] if is_ambiguous else [best]


def new_search(dots: int, candidate_dots: float, max_chance: float, match_rate_min: float) -> SearchState:
    """Return the initial state of a search.

    Args:
        dots: number of dots in view.
        candidate_dots: number of map dots in the area of the search.
        max_chance: maximum number of expected chance alignments of an accepted pose.
        match_rate_min: minimum match rate of an accepted pose, as a fraction of the dots in view.
    """
    poses = np.array([(math.inf, 1.0, 0.0, 0.0)] * 2, dtype=_POSE)
    counts, matches = np.zeros(3, dtype=np.int64), np.empty(dots, dtype=np.int64)
    return SearchState(
        poses, counts, matches, np.empty(dots), candidate_dots, math.log(max_chance), match_rate_min * dots
    )


@register_jitable
def is_accepted(search: SearchState, pose: ScoredPose) -> bool:
    """Return whether a pose of the search is significant."""
    return pose.log_chance < search.log_threshold and pose.matched >= search.min_matches


@njit(cache=True)
def score_hypothesis(grid: DotGrid, view: ViewDots, search: SearchState, a: complex, b: complex) -> bool:
    """Match the whole view under a hypothesis, update best pose and runner-up; return whether the best is accepted."""
    search.counts[2] += 1
    pose = _score_match(view, search, match_view(grid, view, a, b, search.matches, search.residuals))
    if not is_accepted(search, pose):
        robust = _score_match(
            view, search, match_view_robustly(grid, view, pose.a, pose.b, search.matches, search.residuals)
        )
        if robust.log_chance < pose.log_chance:
            pose = robust
    best, runner_up = search.poses[BEST], search.poses[RUNNER_UP]
    if pose.log_chance < best.log_chance:
        if not _is_same_pose(grid, view, pose, best):
            _store(best, runner_up)
        _store(pose, best)
    elif pose.log_chance < runner_up.log_chance and not _is_same_pose(grid, view, pose, best):
        _store(pose, runner_up)
    return is_accepted(search, best)


@njit(cache=True)
def _store(pose: ScoredPose, target: Any) -> None:
    target.log_chance, target.a, target.b, target.matched = pose.log_chance, pose.a, pose.b, pose.matched


@njit(cache=True)
def _score_match(view: ViewDots, search: SearchState, match: tuple[int, complex, complex]) -> ScoredPose:
    """Return the pose of a match of the whole view, with the residuals in ``search``."""
    matched, a, b = match
    log_chance = math.inf
    if matched >= 3 and abs(abs(a) - 1.0) <= _SCALE_MARGIN * view.scale_tolerance:
        log_chance = log_chance_alignments(
            search.residuals,
            view.z,
            0.5 * view.sigma,
            search.candidate_dots,
            view.density,
            _SCALE_MARGIN * view.scale_tolerance,
        )
    return ScoredPose(log_chance, a, b, float(matched))


@njit(cache=True)
def _is_same_pose(grid: DotGrid, view: ViewDots, pose: ScoredPose, other: ScoredPose) -> bool:
    """Return whether two poses put the view at the same position with the same yaw."""
    turn = pose.a - other.a
    shift = turn * view.z[0] + (pose.b - other.b)
    return abs(shift) < 0.5 * grid.cell and abs(turn) < 0.2
