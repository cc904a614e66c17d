"""Odometry of a whole drive, interpolated at the stamps of its images."""

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer


class SurveyOdometry:
    """Odometry in order of time."""

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
            at = 1e-9 * (stamps_ns[back[0]] - stamps_ns[0])
            raise FloorLocalizerError(
                f'{source}: its stamps run backwards {at:.3f} s after the first; record the drive in one go'
            )
        self._start, self._source = int(stamps_ns[0]), source
        self._buffer = OdometryBuffer(history=2**63)  # all of it
        for stamp, pose in zip(stamps_ns.tolist(), poses.tolist(), strict=True):
            self._buffer.add(stamp, SE2(*pose))

    def pose_at(self, stamp_ns: int, name: str) -> SE2:
        """Return ``T_odom_base`` at a stamp; ``name`` is the image, for error messages.

        Raises:
            FloorLocalizerError: there is no odometry near this stamp.
        """
        pose = self._buffer.pose_at(stamp_ns)
        if isinstance(pose, NoPoseReason):
            time = 1e-9 * (stamp_ns - self._start)
            raise FloorLocalizerError(
                f'{self._source}: odometry is missing around {name} ({time:.3f} s after the first); '
                'a survey needs it from the first to the last image'
            )
        return pose
