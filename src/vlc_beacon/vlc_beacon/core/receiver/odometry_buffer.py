"""Odometry buffer with interpolation to the time of an image."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2

_CAPACITY = 400
_STEP_MIN = 1e-3
"""Minimum time between two poses [s]."""
_AGE_MAX = 0.25
"""Maximum time between an image and the nearest odometry pose [s]."""


class OdometryBuffer:
    """Buffer of recent odometry poses."""

    def __init__(self) -> None:
        """Start with an empty buffer."""
        self._poses: deque[tuple[float, SE2]] = deque(maxlen=_CAPACITY)

    def add(self, stamp: float, T_odom_base: SE2) -> None:
        """Add a pose at a time [s]; one that is not newer than the last by the minimum time is skipped."""
        if not self._poses or stamp - self._poses[-1][0] >= _STEP_MIN:
            self._poses.append((stamp, T_odom_base))

    def pose_at(self, stamp: float) -> SE2 | None:
        """Return ``T_odom_base`` at a time [s], interpolated or extrapolated; None if no pose is near.

        Images are often newer than the last pose: then the pose is extrapolated with constant velocity.
        """
        step = self._motion_at(stamp)
        if step is None:
            return None
        begin, pose, velocity = step
        since = stamp - begin
        return pose @ SE2(*(velocity * since).tolist())

    def velocity_at(self, stamp: float) -> NDArray[np.float64]:
        """Return the velocity of the base along its x and y [m/s] and its yaw rate [rad/s]; zeros if unknown."""
        step = self._motion_at(stamp)
        return np.zeros(3) if step is None else step[2]

    def _motion_at(self, stamp: float) -> tuple[float, SE2, NDArray[np.float64]] | None:
        """Return stamp, pose and velocity of the motion segment around a time; None if unknown."""
        if not self._poses:
            return None
        k = min(max(bisect_left(self._poses, stamp, key=lambda entry: entry[0]), 1), len(self._poses) - 1)
        (begin, before), (end, after) = self._poses[max(k - 1, 0)], self._poses[k]
        if min(abs(stamp - begin), abs(stamp - end)) > _AGE_MAX:
            return None
        if end - begin > 2.0 * _AGE_MAX or end <= begin:
            return (end, after, np.zeros(3)) if abs(stamp - end) <= _AGE_MAX else (begin, before, np.zeros(3))
        step = before.inverse() @ after
        return begin, before, np.array([step.x, step.y, step.yaw]) / (end - begin)
