"""Reference line of the robot and its target heading."""

from __future__ import annotations

import math

from shirube_core.geometry import SE2, wrap_angle


class ReferenceLine:
    """A line through a position, and the robot's heading error relative to it.

    The heading is unwrapped, so that a turn by 270 degrees is made in the commanded direction.

    Args:
        start: initial pose of the robot in the map; it defines the line.
    """

    def __init__(self, start: SE2) -> None:
        self._origin = (start.x, start.y)
        self._pose = start
        self._yaw = self._heading = start.yaw

    def update_pose(self, T_map_base: SE2) -> None:
        """Update the robot's pose."""
        self._yaw += wrap_angle(T_map_base.yaw - self._yaw)
        self._pose = T_map_base

    def rotate(self, angle: float) -> None:
        """Rotate the line [rad]; its origin is set when the turn is complete, see `restart_at_robot`."""
        self._heading += angle

    def restart_at_robot(self) -> None:
        """Move the origin of the line to the robot's position."""
        self._origin = (self._pose.x, self._pose.y)

    @property
    def remaining_turn(self) -> float:
        """Heading error: angle from the robot's heading to the line [rad]."""
        return self._heading - self._yaw

    def steering_angle(self, distance: float) -> float:
        """Return the angle from the robot's heading to the heading that leads back to the line [rad].

        Args:
            distance: lookahead distance along the line [m].
        """
        dx, dy = self._pose.x - self._origin[0], self._pose.y - self._origin[1]
        cross_track_error = math.cos(self._heading) * dy - math.sin(self._heading) * dx
        return wrap_angle(self.remaining_turn - math.atan2(cross_track_error, distance))
