"""What self-location at a place answers: a displacement with its evidence, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose


@dataclass(frozen=True)
class PlaceFix:
    """Where the robot is in the frame of a taught place: that of the level base when it was taught.

    Attributes:
        T_place_base: the robot's pose.
        height: of the base over the taught one [m].
        tilt: roll and pitch of the base, known ones corrected by what the points tell [rad].
        covariance: shape (4, 4), of x, y, z [m] and yaw [rad].
        names: of the points it is made of.
        residuals: shape (n, 4), what is left of these points, u, v left and u, v right [px].
    """

    T_place_base: PlanarPose
    height: float
    tilt: tuple[float, float]
    covariance: NDArray[np.float64]
    names: tuple[str, ...]
    residuals: NDArray[np.float64]


class NoPlaceFixReason(Enum):
    """Why there is no displacement."""

    TOO_FEW_POINTS = 'too few points'
    ROWS_APART = 'left and right show the points in different rows; calibrate the cameras as a pair'
    INCONSISTENT = 'the distances between the points are not the taught ones'
    POOR_GEOMETRY = 'the points do not tell the displacement'
    UNCERTAIN = 'the displacement is too uncertain'


@dataclass(frozen=True)
class NoPlaceFix:
    """No displacement, and why.

    Attributes:
        reason: the kind of failure.
        detail: numbers to it, for the diagnostics.
    """

    reason: NoPlaceFixReason
    detail: str
