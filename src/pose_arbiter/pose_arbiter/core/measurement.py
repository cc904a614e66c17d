"""Pose measurements: their status after outlier rejection, and validation of messages before the filter."""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

from pose_arbiter.core.covariance import Covariance, is_positive_definite
from shirube_core.geometry import SE2

_FARTHEST = 1e6  # [m]
_VAR_MIN, _VAR_XY_MAX, _VAR_YAW_MAX = 1e-14, 1e4, math.tau**2


class MeasurementStatus(Enum):
    """Result of outlier rejection for one pose; the value is the text of the diagnostics."""

    USED = 'used'
    RESET = 'estimate reset to it'
    WAITING = 'waiting for a second source at start'
    OUTSIDE_GATE = 'outside the gate'
    PROBATION = 'inside the gate again, on probation'
    ODOMETRY_INCONSISTENT = 'inconsistent with odometry'


class RejectReason(Enum):
    """Why a message is rejected before the filter; the value is the text of the diagnostics."""

    NOT_FINITE = 'not finite'
    TOO_FAR = 'farther than 1000 km from the origin'
    BAD_COVARIANCE = 'covariance is invalid'
    NO_STAMP = 'stamp is 0'
    FUTURE = 'stamp is in the future'
    TOO_OLD = 'stamp is too old'
    DUPLICATE = 'duplicate stamp'


class PoseMeasurement(NamedTuple):
    """A measured pose. Measurements are processed in the sort order of this tuple.

    Attributes:
        stamp: stamp [ns].
        source: source index; -1 is a pose set by an operator.
        pose: ``T_map_base``.
        noise: covariance R of the measurement.
    """

    stamp: int
    source: int
    pose: SE2
    noise: Covariance


def validate_pose(pose: SE2) -> RejectReason | None:
    """Return the reason a pose is invalid, None if it is valid."""
    if not (math.isfinite(pose.x) and math.isfinite(pose.y) and math.isfinite(pose.yaw)):
        return RejectReason.NOT_FINITE
    if max(abs(pose.x), abs(pose.y)) > _FARTHEST:
        return RejectReason.TOO_FAR
    return None


def validate_covariance(noise: Covariance) -> RejectReason | None:
    """Return the reason a covariance is invalid, None if it is valid."""
    if not is_positive_definite(noise) or min(noise[0], noise[3], noise[5]) < _VAR_MIN:
        return RejectReason.BAD_COVARIANCE
    if max(noise[0], noise[3]) > _VAR_XY_MAX or noise[5] > _VAR_YAW_MAX:
        return RejectReason.BAD_COVARIANCE
    return None
