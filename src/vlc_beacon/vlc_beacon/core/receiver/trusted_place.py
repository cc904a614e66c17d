"""Whether a pose is where odometry leads to from the poses before.

Three copied lamps can move the pose of a robot, and with it the place where a command is obeyed; its wheels they cannot
turn. A robot that was carried elsewhere is believed after a while.
"""

from __future__ import annotations

from shirube_geometry import PlanarPose

JUMP_MAX = 0.3
"""Poses and odometry differ by less from image to image [m]."""
WAIT = 30.0
"""A pose that jumped is believed after so long [s]."""


class TrustedPlace:
    """Carries the last believed pose on by odometry."""

    def __init__(self) -> None:
        """Begin without a pose; the first one is believed."""
        self._believed: tuple[PlanarPose, PlanarPose] | None = None
        self._jumped_at: float | None = None

    def is_believed(self, stamp: float, T_map_base: PlanarPose, T_odom_base: PlanarPose | None) -> bool:
        """Take a pose and return whether commands may rely on it.

        Args:
            stamp: of the pose [s].
            T_map_base: the pose.
            T_odom_base: odometry at the stamp; without odometry every pose is believed.
        """
        if T_odom_base is None or self._agrees(T_map_base, T_odom_base):
            self._jumped_at = None
        elif self._jumped_at is None:
            self._jumped_at = stamp
        if self._jumped_at is not None and abs(stamp - self._jumped_at) < WAIT:
            return False
        self._jumped_at = None
        self._believed = None if T_odom_base is None else (T_map_base, T_odom_base)
        return True

    def _agrees(self, T_map_base: PlanarPose, T_odom_base: PlanarPose) -> bool:
        if self._believed is None:
            return True
        map_before, odom_before = self._believed
        expected = map_before @ odom_before.inverse() @ T_odom_base
        return expected.distance_to(T_map_base) < JUMP_MAX
