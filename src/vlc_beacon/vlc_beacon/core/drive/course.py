"""The line that the robot follows and the heading that it turns to."""

from __future__ import annotations

import math

from shirube_geometry import PlanarPose, wrap_angle


class Course:
    """A line through a place, and how far the robot has turned away from it.

    The heading counts on beyond half a turn, so that "turn by 270 degrees" goes the way it says.

    Args:
        start: pose of the robot in the map, on the line and along it.
    """

    def __init__(self, start: PlanarPose) -> None:
        self._origin = (start.x, start.y)
        self._pose = start
        self._yaw = self._heading = start.yaw

    def robot_at(self, T_map_base: PlanarPose) -> None:
        """Take the robot's pose."""
        self._yaw += wrap_angle(T_map_base.yaw - self._yaw)
        self._pose = T_map_base

    def turn(self, angle: float) -> None:
        """Turn the line [rad]; it gets its place when the turn is done, see `begin_line`."""
        self._heading += angle

    def begin_line(self) -> None:
        """Lay the line through where the robot is."""
        self._origin = (self._pose.x, self._pose.y)

    @property
    def left_to_turn(self) -> float:
        """Angle from the robot's heading to that of the line [rad]."""
        return self._heading - self._yaw

    def angle_to_line(self, distance: float) -> float:
        """Return the angle from the robot's heading to one that leads back to the line [rad].

        Args:
            distance: along the line, over which the robot comes back [m].
        """
        dx, dy = self._pose.x - self._origin[0], self._pose.y - self._origin[1]
        aside = math.cos(self._heading) * dy - math.sin(self._heading) * dx
        return wrap_angle(self.left_to_turn - math.atan2(aside, distance))
