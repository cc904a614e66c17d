"""What the search for targets answers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import StereoPoints


@dataclass(frozen=True)
class TargetSighting:
    """A target that was found.

    Attributes:
        target: its name.
        state: shape (4,), x, y, z [m] and yaw [rad] of the robot in the place's frame, roughly.
        points: measured in the grey images, named ``target/primitive/point``.
        found: names of the primitives that were found.
        evidence: log likelihood above chance.
    """

    target: str
    state: NDArray[np.float64]
    points: StereoPoints
    found: tuple[str, ...]
    evidence: float


class NoSightingReason(Enum):
    """Why a target is not found."""

    NO_CANDIDATE = 'nothing looks like it'
    NO_EVIDENCE = 'what looks like it could be chance'
    AMBIGUOUS = 'it may be in several places'


@dataclass(frozen=True)
class NoTargetSighting:
    """A target that was not found, and why.

    Attributes:
        target: its name.
        reason: the kind of failure.
        detail: numbers to it, for the diagnostics.
    """

    target: str
    reason: NoSightingReason
    detail: str
