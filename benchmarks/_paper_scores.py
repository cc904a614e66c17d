"""What a matcher's answers are worth against the truth of the simulated views."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from _paper_matchers import MATCHERS, view_points
from _paper_views import CAMERA, FLOOR_SIZE, MOUNT, NOISE, PaperView, paper_floor, paper_places, paper_views
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.distance import pdist

from floor_localizer.core.constellation.acceptance import log_chance_alignments
from floor_localizer.core.pole_star.pole_star_matcher import (
    PoleStarMatcher,
    PoleStarPose,
    PoleStarSettings,
    build_address_matrix,
    match_rate,
)
from floor_localizer.core.settings import LocalizerSettings
from shirube_core.geometry import SE2

RIGHT_WITHIN = 0.002
RIGHT_TURN = math.radians(1.5)
# A candidate nearer to the truth than this [m] is the truth, ill fitted, and no rival of it.
ELSEWHERE = 0.02


@dataclass(frozen=True)
class Score:
    """One answer against the truth.

    Attributes:
        verdict: 'right' (within 2 mm and 1.5 degrees), 'wrong' or 'none'.
        reason: why there is no pose.
        position_error: distance from the true place, NaN without a pose [m].
        heading_error: turn from the true heading, NaN without a pose [rad].
        match_rate: the paper's match rate at the pose (2.3.3), NaN without one.
        runner_up_rate: the highest match rate of a wrong candidate, NaN where it was not asked for.
        chance_alignments: expected number of poses that match by chance as well as the truth does.
        seconds: time to the answer.
    """

    verdict: str
    reason: str
    position_error: float
    heading_error: float
    match_rate: float
    runner_up_rate: float
    chance_alignments: float
    seconds: float


class Scorer:
    """Asks one matcher about views of one floor."""

    def __init__(self, matcher: str, seed: int) -> None:
        """Build the matcher's database, and let it compile what it compiles.

        Args:
            matcher: a name in ``MATCHERS``.
            seed: random seed of the floor.
        """
        self._floor = paper_floor(seed)
        self._tree = KDTree(self._floor)
        self._addresses = build_address_matrix(self._floor, PoleStarSettings().address_block)
        self._locate = MATCHERS[matcher](self._floor)
        for view in paper_views(self._floor, paper_places()[:2], 0.5, 0.5, seed):
            self._locate(view.pixels)

    @cached_property
    def _pole_star(self) -> PoleStarMatcher:
        return PoleStarMatcher(self._floor, PoleStarSettings())

    def score(self, view: PaperView, *, with_runners_up: bool) -> Score:
        """Return what the matcher's answer is worth.

        Args:
            view: the dots and the truth.
            with_runners_up: whether the best wrong candidate is asked for; the pole-star pipeline names the
                candidates of a matcher that does not.
        """
        begin = time.perf_counter()
        answer = self._locate(view.pixels)
        seconds = time.perf_counter() - begin
        points, found, truth = view_points(view.pixels), answer.T_map_view, view.T_map_view
        runner_up_rate = math.nan
        if with_runners_up:
            runner_up_rate = _runner_up_rate(
                answer.candidates or self._pole_star.congruent_poses(points), truth
            )
        chance = self._chance_alignments(points, view.map_dots)
        if found is None:
            return Score('none', answer.reason, math.nan, math.nan, math.nan, runner_up_rate, chance, seconds)
        distance, turn = found.distance_to(truth), abs(found.yaw_to(truth))
        verdict = 'right' if distance <= RIGHT_WITHIN and turn <= RIGHT_TURN else 'wrong'
        rate = match_rate(self._addresses, found.transform(points))
        return Score(verdict, '', distance, turn, rate, runner_up_rate, chance, seconds)

    def _chance_alignments(self, points: NDArray[np.float64], map_dots: NDArray[np.intp]) -> float:
        """Return how many poses by chance match as well as the best fit to the true dots."""
        true = map_dots >= 0
        if true.sum() < 2:
            return math.inf
        view = points @ np.array([1.0, 1.0j])
        on_map = self._floor[map_dots[true]] @ np.array([1.0, 1.0j])
        centred = view[true] - view[true].mean()
        scale_and_turn = np.vdot(centred, on_map) / np.vdot(centred, centred)
        aligned = scale_and_turn * (view - view[true].mean()) + on_map.mean()
        residuals, _ = self._tree.query(np.column_stack([aligned.real, aligned.imag]))
        log_chance = log_chance_alignments(
            residuals,
            0.5 * NOISE * MOUNT.xyz[2] / CAMERA.fx,
            float(pdist(points[true]).max()),
            float(len(self._floor)),
            len(self._floor) / math.prod(FLOOR_SIZE),
            LocalizerSettings().scale_tolerance,
        )
        return math.exp(min(log_chance, 700.0))


def _runner_up_rate(candidates: Sequence[PoleStarPose], truth: SE2) -> float:
    rates = [pose.match_rate for pose in candidates if pose.T_map_view.distance_to(truth) > ELSEWHERE]
    return max(rates, default=0.0)


@cache
def scorer(matcher: str, seed: int) -> Scorer:
    """Return this process's scorer; it takes some seconds to build."""
    return Scorer(matcher, seed)
