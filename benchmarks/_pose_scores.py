"""Poses against the truth: right, none or wrong, and errors measured in their own standard deviations."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.fix import Fix, NoFix
from shirube_core.geometry import SE2

RIGHT_WITHIN, RIGHT_TURN = 0.002, math.radians(1.5)
EXACT_WITHIN = 0.0005


@dataclass(frozen=True)
class PoseScore:
    """One answer against the truth.

    Attributes:
        verdict: 'right' (within 2 mm and 1.5 degrees), 'wrong' or 'none'.
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
    is_right = math.hypot(error[0], error[1]) < RIGHT_WITHIN and abs(error[2]) < RIGHT_TURN
    return PoseScore('right' if is_right else 'wrong', '', error, result.covariance)


def whitened_rms(scores: Sequence[PoseScore]) -> NDArray[np.float64]:
    """Return the rms error of x, y, yaw and of all three over the stated covariance, shape (4,); 1 is consistent.

    A component is divided by its own standard deviation; all three together count by the square root of the mean
    of e^T C^-1 e / 3.
    """
    right = [score for score in scores if score.verdict == 'right']
    if not right:
        return np.full(4, math.nan)
    errors = np.array([score.error for score in right])
    covariances = np.array([score.covariance for score in right])
    components = np.mean(errors**2 / np.diagonal(covariances, axis1=1, axis2=2), axis=0)
    return np.sqrt(np.append(components, np.mean(normalised_squares(errors, covariances)) / 3.0))


def normalised_squares(errors: NDArray[np.float64], covariances: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return e^T C^-1 e of each error, shape (n,): chi-square with three degrees of freedom when C is true."""
    return np.einsum('ni,nij,nj->n', errors, np.linalg.inv(covariances), errors)


def verdicts(scores: Sequence[PoseScore]) -> str:
    """Return the shares of right, none and wrong."""
    count = Counter(score.verdict for score in scores)
    return ' / '.join(percent(count[verdict] / len(scores)) for verdict in ('right', 'none', 'wrong'))


def percent(share: float) -> str:
    """Return a share as per cent, without zeros behind the point."""
    return f'{100.0 * share:.2f}'.rstrip('0').rstrip('.')


def spread(values: Sequence[float], form: str) -> str:
    """Return median, rms, 95 % and maximum of errors for a table."""
    if not values:
        return '–'
    middle, high, most = np.percentile(values, [50, 95, 100])
    rms = math.sqrt(np.mean(np.square(values)))
    return ' / '.join(format(value, form) for value in (middle, rms, high, most))
