"""Step 1 of the paper (2.3): where its surroundings are unknown, the robot turns once around to map them."""

import math

import numpy as np

from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import UNKNOWN, GridFrame
from shirube_core.geometry import SE2, wrap_angle

RADIUS = 1.0
"""Radius of the surroundings, and least distance between two places of looking around [m]."""
_UNKNOWN_FRACTION = 0.5  # of the surroundings at which the robot looks around


class LookAround:
    """Decides when the robot looks around, and measures its turn."""

    def __init__(self, global_map: GlobalMap) -> None:
        """Start where nothing was looked at; the map is only read."""
        self._global_map = global_map
        self.reset()

    def reset(self) -> None:
        """Forget the places of looking around, for instance after the map was cleared."""
        self._places: list[SE2] = []
        self._checked: SE2 | None = None
        self._turned = math.inf  # a turn of less than 2 pi is under way [rad]

    def update(self, robot: SE2) -> bool:
        """Return whether the robot has to turn, given its pose in the map."""
        if self._turned < math.tau and self._checked is not None:
            self._turned += wrap_angle(self._checked.yaw_to(robot))
            self._checked = robot
            return self._turned < math.tau
        # Checked anew after each part of the radius.
        if self._checked is not None and self._checked.distance_to(robot) < 0.2 * RADIUS:
            return False
        self._checked = robot
        was_here = any(place.distance_to(robot) < RADIUS for place in self._places)
        if was_here or self._unknown_fraction(robot) < _UNKNOWN_FRACTION:
            return False
        self._places.append(robot)
        self._turned = 0.0
        return True

    def _unknown_fraction(self, robot: SE2) -> float:
        resolution = self._global_map.resolution
        cells = math.ceil(RADIUS / resolution)
        x, y = (resolution * (math.floor(number / resolution) - cells) for number in (robot.x, robot.y))
        frame = GridFrame(x, y, resolution, 2 * cells + 1, 2 * cells + 1)
        rows, columns = np.indices(frame.shape) - cells
        is_near = rows**2 + columns**2 <= cells**2
        return float((self._global_map.occupancy_in(frame)[is_near] == UNKNOWN).mean())
