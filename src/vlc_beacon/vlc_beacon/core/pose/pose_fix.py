"""What localization by lamps answers: a pose with its evidence, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from shirube_geometry import PlanarPose

PLANAR = np.ix_([0, 1, 3], [0, 1, 3])
"""x, y and yaw among x, y, z and yaw."""


class DoubtKind(Enum):
    """What is wrong with a lamp."""

    MOVED = 'moved'
    SWAPPED = 'swapped'
    COPIED = 'copied'
    UNCLEAR = 'does not fit the others'


@dataclass(frozen=True)
class BeaconDoubt:
    """A lamp that is not where the file says.

    Attributes:
        id: that it plays.
        sighting: its index among the sightings.
        kind: what is wrong with it.
        swapped_with: whose place it has, None unless it is swapped.
        seen_at: where it hangs if its height is right, in the map frame [m]; NaN where there is no pose.
    """

    id: int
    sighting: int
    kind: DoubtKind
    swapped_with: int | None = None
    seen_at: tuple[float, float, float] = (float('nan'), float('nan'), float('nan'))


@dataclass(frozen=True)
class BeaconFix:
    """A pose.

    Attributes:
        T_map_base: the robot's pose.
        height: of the base in the map frame [m].
        covariance: shape (4, 4), of x, y, z [m] and yaw [rad].
        tilt: error of the known roll and pitch as far as the lamps tell it [rad].
        used: shape (n,), which sightings the pose is made of.
        residuals: shape (n, 2), what the pose leaves unexplained of the rays, in standard deviations.
        doubts: lamps that are not where the file says.
    """

    T_map_base: PlanarPose
    height: float
    covariance: NDArray[np.float64]
    tilt: tuple[float, float]
    used: NDArray[np.bool_]
    residuals: NDArray[np.float64]
    doubts: tuple[BeaconDoubt, ...] = ()

    @property
    def planar_covariance(self) -> NDArray[np.float64]:
        """Shape (3, 3), of x, y [m] and yaw [rad]."""
        return self.covariance[PLANAR]


class NoFixReason(Enum):
    """Why there is no pose."""

    NO_LAMP = 'no known lamp in view'
    TOO_FEW_LAMPS = 'too few lamps in view for a pose'
    POOR_GEOMETRY = 'the lamps in view stand too close together'
    AMBIGUOUS = 'the lamps fit more than one pose'
    INCONSISTENT = 'the lamps in view do not fit together'
    UNEXPECTED = 'the pose is not where the robot is expected'


@dataclass(frozen=True)
class NoBeaconFix:
    """No pose, and why.

    Attributes:
        reason: the kind of failure.
        detail: numbers and names to it, for the diagnostics.
        doubts: lamps one of which at least is not where the file says.
    """

    reason: NoFixReason
    detail: str
    doubts: tuple[BeaconDoubt, ...] = ()


@dataclass(frozen=True)
class ExpectedPose:
    """Where the robot is expected, from odometry.

    Attributes:
        T_map_base: the expected pose.
        covariance: shape (3, 3), of x, y [m] and yaw [rad].
    """

    T_map_base: PlanarPose
    covariance: NDArray[np.float64]

    def distance_of(self, pose: PlanarPose, covariance: NDArray[np.float64]) -> float:
        """Return how many standard deviations a measured pose is away from it.

        Args:
            pose: as measured, its errors independent of the expectation's.
            covariance: shape (3, 3), of its x, y [m] and yaw [rad].
        """
        offset = np.array(
            [pose.x - self.T_map_base.x, pose.y - self.T_map_base.y, self.T_map_base.turn_to(pose)]
        )
        return float(np.sqrt(offset @ np.linalg.solve(self.covariance + covariance, offset)))
