"""Odometry at the time of an image."""

import numpy as np
from numpy.typing import NDArray

from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer


class LampOdometry:
    """Recent odometry by time in seconds."""

    def __init__(self) -> None:
        """Start with an empty buffer."""
        self._buffer = OdometryBuffer()

    def add(self, stamp: float, T_odom_base: SE2) -> None:
        """Add a pose at a time [s], in any order."""
        self._buffer.add(round(1e9 * stamp), T_odom_base)

    def pose_at(self, stamp: float) -> SE2 | None:
        """Return ``T_odom_base`` at a time [s], interpolated or shortly extrapolated; None if no pose is near."""
        pose = self._buffer.pose_at(round(1e9 * stamp))
        return None if isinstance(pose, NoPoseReason) else pose

    def velocity_at(self, stamp: float) -> NDArray[np.float64]:
        """Return the velocity of the base along its x and y [m/s] and its yaw rate [rad/s]; zeros if unknown."""
        return np.array(self._buffer.twist_at(round(1e9 * stamp)))

    def has_jumped(self, start: float, end: float) -> bool:
        """Return whether the odometry jumped between two times [s]."""
        return self._buffer.motion(round(1e9 * start), round(1e9 * end)) is NoPoseReason.JUMPED
