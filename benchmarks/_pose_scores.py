"""Poses against the truth: right, none or wrong, times, and errors measured in their own standard deviations."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from _figures import Figure, error, outcomes, ratio, time
from _harness import cpu_time
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix, NoFix
from shirube_core.geometry import SE2

RIGHT_WITHIN, RIGHT_TURN = 0.002, math.radians(1.5)
EXACT_WITHIN = 0.0005

Seen = TypeVar('Seen')


@dataclass(frozen=True)
class PoseScore:
    """One answer against the truth.

    Attributes:
        verdict: 'right', 'wrong' or 'none'.
        reason: why there is no pose, '' with one.
        error: shape (3,), x, y [m] and yaw [rad], NaN without a pose.
        covariance: shape (3, 3), as the localizer states it, NaN without a pose.
        milliseconds: processor time, NaN where it was not measured.
    """

    verdict: str
    reason: str = ''
    error: NDArray[np.float64] = field(default_factory=lambda: np.full(3, math.nan))
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.full((3, 3), math.nan))
    milliseconds: float = math.nan

    @property
    def distance(self) -> float:
        """Error of the position [m]."""
        return math.hypot(self.error[0], self.error[1])

    @property
    def turn(self) -> float:
        """Error of the heading, without its sign [rad]."""
        return abs(float(self.error[2]))


def verdict_of(found: SE2, truth: SE2, within: tuple[float, float] = (RIGHT_WITHIN, RIGHT_TURN)) -> str:
    """Return 'right' (within 2 mm and 1.5 degrees, unless other limits are given [m, rad]) or 'wrong'."""
    is_right = found.distance_to(truth) <= within[0] and abs(found.yaw_to(truth)) <= within[1]
    return 'right' if is_right else 'wrong'


def score_found(
    found: SE2 | None, truth: SE2, within: tuple[float, float] = (RIGHT_WITHIN, RIGHT_TURN), **more: Any
) -> PoseScore:
    """Return what a pose, or none, is worth; more attributes are passed on."""
    if found is None:
        return PoseScore('none', **more)
    error = np.array([found.x - truth.x, found.y - truth.y, truth.yaw_to(found)])
    return PoseScore(verdict_of(found, truth, within), error=error, **more)


def score_pose(result: Fix | NoFix, truth: SE2) -> PoseScore:
    """Return what an answer of the localizer is worth."""
    if isinstance(result, Fix):
        return score_found(result.T_map_base, truth, covariance=result.covariance)
    return PoseScore('none', result.reason.value)


def time_answer(locate: Callable[[Seen], SE2 | None], seen: Seen, truth: SE2) -> PoseScore:
    """Ask for the pose of what is seen."""
    found, milliseconds = cpu_time(locate, seen)
    return score_found(found, truth, milliseconds=milliseconds)


def pose_cells(
    scores: Sequence[PoseScore],
    form: str = '.3f',
    heading_form: str = '.3f',
    scale: float = 1e3,
    shown: Sequence[float] = (50.0, 95.0),
) -> tuple[Figure, Figure, Figure]:
    """Return three cells: right / none / wrong, and percentiles of the errors of position [mm] and heading [°] of what
    is right.
    """
    right = [score for score in scores if score.verdict == 'right']
    return (
        outcomes(score.verdict for score in scores),
        error([score.distance for score in right], form, scale, shown),
        error([score.turn for score in right], heading_form, math.degrees(1.0), shown),
    )


def time_cells(
    scores: Sequence[PoseScore], base: Sequence[PoseScore], form: str = '.2f', better: str = 'lower'
) -> tuple[Figure, Figure, Figure]:
    """Return three cells: times, their median in units of others, and right / none / wrong."""
    ours, theirs = ([score.milliseconds for score in each] for each in (scores, base))
    units = ratio(ours, theirs, better=better)
    return time(ours, form), units, outcomes(score.verdict for score in scores)


def whitened_errors(scores: Sequence[PoseScore]) -> NDArray[np.float64]:
    """Return the errors of right poses, by the stated covariance, shape (n, 3); normal deviates if it is true."""
    right = [score for score in scores if score.verdict == 'right']
    errors = np.array([score.error for score in right]).reshape(-1, 3)
    covariances = np.array([score.covariance for score in right]).reshape(-1, 3, 3)
    return np.linalg.solve(np.linalg.cholesky(covariances), errors[..., None])[..., 0]
