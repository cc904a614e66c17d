"""Odometry consistency check of poses.

Three spoofed lamps can displace the pose, and with it the location where a command is accepted, but not the odometry.
Without odometry, the distance to the last pose is limited by the maximum speed. Small steps must not accumulate: a pose
must also be consistent with an older anchor pose. A relocated robot is accepted after a waiting time.
"""

from shirube_core.geometry import SE2

JUMP_MAX = 0.3
"""Maximum difference between poses and odometry [m]."""
DRIFT_FRACTION = 0.05
"""Additional difference as a fraction of the driven distance."""
SPEED_MAX = 2.0
"""Maximum speed of an indoor robot [m/s]."""
ACCEPT_AFTER = 30.0
"""Time after which poses are accepted again after a jump [s]."""
ANCHOR_TIME = 10.0
"""Age at which the anchor pose is replaced [s]."""

_StampedPose = tuple[float, SE2, SE2 | None]
"""Stamp [s], ``T_map_base`` and ``T_odom_base``."""


class PoseConsistencyCheck:
    """Compares poses with the last accepted pose and an anchor pose."""

    def __init__(self) -> None:
        self._anchor: _StampedPose | None = None
        self._last: _StampedPose | None = None
        self._jump_stamp: float | None = None

    def is_consistent(self, stamp: float, T_map_base: SE2, T_odom_base: SE2 | None) -> bool:
        """Check a pose, with odometry if available, and return whether it may authorize commands."""
        now = stamp, T_map_base, T_odom_base
        is_compatible = all(self._is_compatible(before, now) for before in (self._anchor, self._last))
        if not is_compatible:
            if self._jump_stamp is None:
                self._jump_stamp = stamp
            if abs(stamp - self._jump_stamp) < ACCEPT_AFTER:
                return False
        self._jump_stamp = None
        self._last = now
        if self._anchor is None or not is_compatible or abs(stamp - self._anchor[0]) > ANCHOR_TIME:
            self._anchor = now
        return True

    def drop_odometry(self) -> None:
        """Compare with the earlier poses by the maximum speed only, because the odometry jumped."""
        self._anchor, self._last = _without_odometry(self._anchor), _without_odometry(self._last)

    def _is_compatible(self, before: _StampedPose | None, now: _StampedPose) -> bool:
        if before is None:
            return True
        (then, map_before, odom_before), (stamp, T_map_base, T_odom_base) = before, now
        if T_odom_base is None or odom_before is None:
            # Rejected poses in between do not extend the possible distance.
            until = stamp if self._jump_stamp is None else self._jump_stamp
            return map_before.distance_to(T_map_base) < JUMP_MAX + SPEED_MAX * abs(until - then)
        expected = map_before @ odom_before.inverse() @ T_odom_base
        return expected.distance_to(T_map_base) < JUMP_MAX + DRIFT_FRACTION * odom_before.distance_to(T_odom_base)


def _without_odometry(pose: _StampedPose | None) -> _StampedPose | None:
    return pose and (*pose[:2], None)
