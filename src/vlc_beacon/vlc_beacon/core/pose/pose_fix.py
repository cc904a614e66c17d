"""Result of localization: a pose with its diagnostics, or the reason for no pose."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2

PLANAR = np.ix_([0, 1, 3], [0, 1, 3])
"""Indices of x, y and yaw among x, y, z and yaw."""


class AnomalyKind(Enum):
    """Kind of a beacon anomaly."""

    MOVED = 'moved'
    SWAPPED = 'swapped'
    DUPLICATED = 'duplicated'
    UNCLEAR = 'inconsistent with the others'


@dataclass(frozen=True)
class BeaconAnomaly:
    """A lamp that is not at its position in the beacons file.

    Attributes:
        id: received ID.
        observation: index of its observation.
        kind: kind of the anomaly.
        swapped_with: ID of the lamp whose position it has, None unless it is swapped.
    """

    id: int
    observation: int
    kind: AnomalyKind
    swapped_with: int | None = None


@dataclass(frozen=True)
class BeaconFix:
    """A pose from lamps.

    Attributes:
        T_map_base: the robot's pose.
        height: height of the base in the map frame [m].
        covariance: covariance of x, y, z [m] and yaw [rad], shape (4, 4).
        tilt: estimated error of the known roll and pitch [rad].
        used: mask of the observations used for the pose, shape (n,).
        residuals: normalized residuals of the rays, shape (n, 2) [standard deviations].
        anomalies: lamps that are not at their position in the file.
    """

    T_map_base: SE2
    height: float
    covariance: NDArray[np.float64]
    tilt: tuple[float, float]
    used: NDArray[np.bool_]
    residuals: NDArray[np.float64]
    anomalies: tuple[BeaconAnomaly, ...] = ()

    @property
    def planar_covariance(self) -> NDArray[np.float64]:
        """Covariance of x, y [m] and yaw [rad], shape (3, 3)."""
        return self.covariance[PLANAR]


class NoFixReason(Enum):
    """Reason for no pose."""

    NO_LAMP = 'no known lamp in view'
    TOO_FEW_LAMPS = 'too few lamps in view for a pose'
    POOR_GEOMETRY = 'the lamps in view are too close together'
    AMBIGUOUS = 'the lamps fit more than one pose'
    INCONSISTENT = 'the lamps in view are inconsistent'
    UNEXPECTED = 'the pose is inconsistent with the expected pose'


@dataclass(frozen=True)
class NoBeaconFix:
    """No pose, with the reason.

    Attributes:
        reason: kind of the failure.
        detail: details for the diagnostics.
        anomalies: lamps, at least one of which is not at its position in the file.
    """

    reason: NoFixReason
    detail: str
    anomalies: tuple[BeaconAnomaly, ...] = ()


@dataclass(frozen=True)
class ExpectedPose:
    """Pose predicted from odometry, and covariance of its x, y [m] and yaw [rad], shape (3, 3)."""

    T_map_base: SE2
    covariance: NDArray[np.float64]

    def mahalanobis_distance(self, pose: SE2, covariance: NDArray[np.float64]) -> float:
        """Return the Mahalanobis distance of an independent pose with its covariance, shape (3, 3)."""
        offset = np.array([pose.x - self.T_map_base.x, pose.y - self.T_map_base.y, self.T_map_base.yaw_to(pose)])
        return float(np.sqrt(offset @ np.linalg.solve(self.covariance + covariance, offset)))
