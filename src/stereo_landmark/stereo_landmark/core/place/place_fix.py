"""Result of localization at a place: a displacement with its covariance, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2


@dataclass(frozen=True)
class PlaceFix:
    """Pose of the robot in the frame of a taught place, which is the gravity-aligned base frame at teaching time.

    Attributes:
        T_place_base: pose of the robot in the frame of the place.
        height: height of the base above the taught pose [m].
        tilt: estimated roll and pitch of the base [rad].
        covariance: covariance of x, y, z [m] and yaw [rad], shape (4, 4).
        names: names of the inlier points.
        residuals: reprojection residuals of these points, u, v left and u, v right, shape (n, 4) [px].
    """

    T_place_base: SE2
    height: float
    tilt: tuple[float, float]
    covariance: NDArray[np.float64]
    names: tuple[str, ...]
    residuals: NDArray[np.float64]


class NoPlaceFixReason(Enum):
    """Why there is no displacement."""

    TOO_FEW_POINTS = 'too few points'
    ROW_MISMATCH = 'left and right show the points in different rows; calibrate the cameras as a pair'
    INCONSISTENT = 'the distances between the points are not the taught ones'
    POOR_GEOMETRY = 'the points do not determine the displacement'
    UNCERTAIN = 'the displacement is too uncertain'


@dataclass(frozen=True)
class NoPlaceFix:
    """No displacement, and why.

    Attributes:
        reason: the kind of failure.
        detail: numbers for the diagnostics.
    """

    reason: NoPlaceFixReason
    detail: str
