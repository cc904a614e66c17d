"""Results of the target search."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import StereoPoints


@dataclass(frozen=True)
class TargetDetection:
    """A detected target.

    Attributes:
        target: name of the target.
        state: coarse x, y, z [m] and yaw [rad] of the robot in the place's frame, shape (4,).
        points: points refined in the grey images, named ``target/primitive/point``.
        found: names of the detected primitives.
        log_likelihood_ratio: log-likelihood ratio against chance.
    """

    target: str
    state: NDArray[np.float64]
    points: StereoPoints
    found: tuple[str, ...]
    log_likelihood_ratio: float


class NoDetectionReason(Enum):
    """Why a target is not detected."""

    NO_CANDIDATE = 'no similar shapes in view'
    NOT_SIGNIFICANT = 'the match could be due to chance'
    AMBIGUOUS = 'ambiguous: several poses match'


@dataclass(frozen=True)
class NoTargetDetection:
    """A target that was not detected, and why.

    Attributes:
        target: name of the target.
        reason: kind of failure.
        detail: numbers for the diagnostics.
    """

    target: str
    reason: NoDetectionReason
    detail: str
