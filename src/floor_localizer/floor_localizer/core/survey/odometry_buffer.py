"""Odometry interpolated at the stamp of an image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2, wrap_angle

# Largest time between an image and the nearest odometry [s].
_MAX_AGE = 0.25
_NANOSECONDS = 1e9


class OdometryBuffer:
    """Odometry in order of time, interpolated linearly."""

    def __init__(self, stamps_ns: NDArray[np.int64], poses: NDArray[np.float64], source: str) -> None:
        """Check and store the odometry.

        Args:
            stamps_ns: stamps, shape (n,) [ns].
            poses: x, y [m] and yaw [rad], shape (n, 3).
            source: topic or file, for error messages.

        Raises:
            FloorLocalizerError: there is no odometry, or its stamps do not increase.
        """
        if len(stamps_ns) < 2:
            raise FloorLocalizerError(
                f'{source}: contains no odometry; a survey needs it from the first to the last image'
            )
        back = np.flatnonzero(np.diff(stamps_ns) <= 0)
        if len(back):
            at = (stamps_ns[back[0]] - stamps_ns[0]) / _NANOSECONDS
            raise FloorLocalizerError(
                f'{source}: its stamps run backwards {at:.3f} s after the first; record the drive in one go'
            )
        self._start, self._source = int(stamps_ns[0]), source
        self._seconds = (stamps_ns - stamps_ns[0]) / _NANOSECONDS
        self._xy, self._yaw = poses[:, :2], np.unwrap(poses[:, 2])

    def pose_at(self, stamp_ns: int, name: str) -> SE2:
        """Return ``T_odom_base`` at a stamp; ``name`` is the image, for error messages.

        Raises:
            FloorLocalizerError: there is no odometry near this stamp.
        """
        time = (stamp_ns - self._start) / _NANOSECONDS
        after = int(np.searchsorted(self._seconds, time))
        near = self._seconds[max(after - 1, 0) : after + 1]
        if np.abs(near - time).max(initial=0.0) > 2.0 * _MAX_AGE or np.abs(near - time).min() > _MAX_AGE:
            raise FloorLocalizerError(
                f'{self._source}: odometry is missing around {name} ({time:.3f} s after the first); '
                'a survey needs it from the first to the last image'
            )
        x, y = (float(np.interp(time, self._seconds, self._xy[:, k])) for k in range(2))
        return SE2(x, y, wrap_angle(float(np.interp(time, self._seconds, self._yaw))))
