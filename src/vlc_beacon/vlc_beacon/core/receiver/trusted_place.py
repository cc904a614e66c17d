"""Whether a pose is where odometry leads to from the poses before.

Three copied lamps can move the pose of a robot, and with it the place where a command is obeyed; its wheels they cannot
turn. Without odometry a pose must not be farther from the last one than a robot can drive: copied lamps make it jump,
too. Small steps do not add up: a pose must agree with one of long ago as well. A robot that was carried elsewhere is
believed after a while.
"""

from __future__ import annotations

from shirube_geometry import PlanarPose

JUMP_MAX = 0.3
"""Poses and odometry differ by less [m]"""
DRIFT = 0.05
"""and this share of the way between them."""
SPEED_MAX = 2.0
"""Of a robot indoors, whoever drives it [m/s]."""
WAIT = 30.0
"""A pose that jumped is believed after so long [s]."""
ANCHOR_TIME = 10.0
"""The pose of long ago is replaced when it is older [s]."""

_Place = tuple[float, PlanarPose, PlanarPose | None]
"""Stamp [s], ``T_map_base`` and ``T_odom_base``."""


class TrustedPlace:
    """Compares poses with the last believed one and one of some time ago."""

    def __init__(self) -> None:
        """Begin without a pose; the first one is believed."""
        self._anchor: _Place | None = None
        self._last: _Place | None = None
        self._jumped_at: float | None = None

    def is_believed(self, stamp: float, T_map_base: PlanarPose, T_odom_base: PlanarPose | None) -> bool:
        """Take a pose and return whether commands may rely on it.

        Args:
            stamp: of the pose [s].
            T_map_base: the pose.
            T_odom_base: odometry at the stamp, None where there is none.
        """
        now = stamp, T_map_base, T_odom_base
        agrees = all(self._agrees(before, now) for before in (self._anchor, self._last))
        if not agrees:
            if self._jumped_at is None:
                self._jumped_at = stamp
            if abs(stamp - self._jumped_at) < WAIT:
                return False
        self._jumped_at = None
        self._last = now
        if self._anchor is None or not agrees or abs(stamp - self._anchor[0]) > ANCHOR_TIME:
            self._anchor = now
        return True

    def _agrees(self, before: _Place | None, now: _Place) -> bool:
        if before is None:
            return True
        (then, map_before, odom_before), (stamp, T_map_base, T_odom_base) = before, now
        if T_odom_base is None or odom_before is None:
            # Poses that were not believed in between are no proof of a drive.
            until = stamp if self._jumped_at is None else self._jumped_at
            return map_before.distance_to(T_map_base) < JUMP_MAX + SPEED_MAX * abs(until - then)
        expected = map_before @ odom_before.inverse() @ T_odom_base
        return expected.distance_to(T_map_base) < JUMP_MAX + DRIFT * odom_before.distance_to(T_odom_base)
