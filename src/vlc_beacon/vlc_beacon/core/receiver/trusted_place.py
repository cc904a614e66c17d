"""Whether a pose is where odometry leads to from the poses before.

Three copied lamps can move the pose of a robot, and with it the place where a command is obeyed; its wheels they cannot
turn. Without odometry a pose must not be farther from the last one than a robot can drive: copied lamps make it jump,
too. A robot that was carried elsewhere is believed after a while.
"""

from __future__ import annotations

from shirube_geometry import PlanarPose

JUMP_MAX = 0.3
"""Poses and odometry differ by less from image to image [m]."""
SPEED_MAX = 2.0
"""Of a robot indoors, whoever drives it [m/s]."""
WAIT = 30.0
"""A pose that jumped is believed after so long [s]."""


class TrustedPlace:
    """Compares poses with the last believed one."""

    def __init__(self) -> None:
        """Begin without a pose; the first one is believed."""
        self._believed: tuple[float, PlanarPose, PlanarPose | None] | None = None
        self._jumped_at: float | None = None

    def is_believed(self, stamp: float, T_map_base: PlanarPose, T_odom_base: PlanarPose | None) -> bool:
        """Take a pose and return whether commands may rely on it.

        Args:
            stamp: of the pose [s].
            T_map_base: the pose.
            T_odom_base: odometry at the stamp, None where there is none.
        """
        if self._agrees(stamp, T_map_base, T_odom_base):
            self._jumped_at = None
        elif self._jumped_at is None:
            self._jumped_at = stamp
        if self._jumped_at is not None and abs(stamp - self._jumped_at) < WAIT:
            return False
        self._jumped_at = None
        self._believed = stamp, T_map_base, T_odom_base
        return True

    def _agrees(self, stamp: float, T_map_base: PlanarPose, T_odom_base: PlanarPose | None) -> bool:
        if self._believed is None:
            return True
        before, map_before, odom_before = self._believed
        if T_odom_base is None or odom_before is None:
            # Poses that were not believed in between are no proof of a drive.
            until = stamp if self._jumped_at is None else self._jumped_at
            return map_before.distance_to(T_map_base) < JUMP_MAX + SPEED_MAX * abs(until - before)
        expected = map_before @ odom_before.inverse() @ T_odom_base
        return expected.distance_to(T_map_base) < JUMP_MAX
