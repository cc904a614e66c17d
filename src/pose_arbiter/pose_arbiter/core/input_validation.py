"""Validates poses and covariances before they reach the filter."""

from __future__ import annotations

import math

from pose_arbiter.core.covariance import Covariance, is_positive_definite
from pose_arbiter.core.measurement_status import RejectReason
from shirube_core.geometry import SE2

_FARTHEST = 1e6  # [m]
_VAR_MIN, _VAR_XY_MAX, _VAR_YAW_MAX = 1e-14, 1e4, math.tau**2


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
