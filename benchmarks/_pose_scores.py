"""Poses against the truth: right, none or wrong, times, and errors measured in their own standard deviations."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from _harness import cpu_time
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix, NoFix
from shirube_core.geometry import SE2

RIGHT_WITHIN, RIGHT_TURN = 0.002, math.radians(1.5)
EXACT_WITHIN = 0.0005

Seen = TypeVar('Seen')


class TimedAnswer(NamedTuple):
    """An answer, 'right', 'wrong' or 'none', and its processor time [ms]."""

    verdict: str
    milliseconds: float


def verdict_of(found: SE2 | None, truth: SE2) -> str:
    """Return 'right' (within 2 mm and 1.5 degrees), 'wrong' or 'none'."""
    if found is None:
        return 'none'
    is_right = found.distance_to(truth) <= RIGHT_WITHIN and abs(found.yaw_to(truth)) <= RIGHT_TURN
    return 'right' if is_right else 'wrong'


def time_answer(locate: Callable[[Seen], SE2 | None], seen: Seen, truth: SE2) -> TimedAnswer:
    """Ask for the pose of what is seen."""
    found, milliseconds = cpu_time(locate, seen)
    return TimedAnswer(verdict_of(found, truth), milliseconds)


@dataclass(frozen=True)
class PoseScore:
    """One answer against the truth.

    Attributes:
        verdict: 'right', 'wrong' or 'none'.
        reason: why there is no pose, '' with one.
        error: shape (3,), x, y [m] and yaw [rad], NaN without a pose.
        covariance: shape (3, 3), as the localizer states it, NaN without a pose.
    """

    verdict: str
    reason: str
    error: NDArray[np.float64]
    covariance: NDArray[np.float64]

    @property
    def distance(self) -> float:
        """Error of the position [m]."""
        return math.hypot(self.error[0], self.error[1])

    @property
    def turn(self) -> float:
        """Error of the heading, without its sign [rad]."""
        return abs(float(self.error[2]))


def score_pose(result: Fix | NoFix, truth: SE2) -> PoseScore:
    """Return what an answer is worth."""
    if not isinstance(result, Fix):
        return PoseScore('none', result.reason.value, np.full(3, math.nan), np.full((3, 3), math.nan))
    found = result.T_map_base
    error = np.array([found.x - truth.x, found.y - truth.y, truth.yaw_to(found)])
    return PoseScore(verdict_of(found, truth), '', error, result.covariance)


def whitened_errors(scores: Sequence[PoseScore]) -> NDArray[np.float64]:
    """Return the errors of right poses, by the stated covariance, shape (n, 3); normal deviates if it is true."""
    right = [score for score in scores if score.verdict == 'right']
    errors = np.array([score.error for score in right]).reshape(-1, 3)
    covariances = np.array([score.covariance for score in right]).reshape(-1, 3, 3)
    return np.linalg.solve(np.linalg.cholesky(covariances), errors[..., None])[..., 0]
