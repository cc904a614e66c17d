"""Whether a robot that should drive does not move, by its poses: held by an obstacle, a monitor or its base."""

import math
from dataclasses import replace

from reward_planner.core.driving.drive_state import DriveCommand, DriveState
from shirube_core.geometry import SE2

STUCK_DETAIL = f'{DriveState.STUCK.value}: obstacles, lamps, a monitor or the base allow no motion'
"""Detail of the state."""
_TIMEOUT = 5.0  # time without motion after which the robot is stuck [s]
_DISTANCE, _ANGLE = 0.04, 0.1  # smaller ones are the noise of the pose [m, rad]


class StuckCheck:
    """Compares the pose with that of some seconds ago.

    Attributes:
        is_stuck: whether the robot has not moved for long.
    """

    def __init__(self) -> None:
        """Start anew."""
        self.reset()

    def reset(self) -> None:
        """Start the time again."""
        self._place: SE2 | None = None
        self._since, self.is_stuck = math.nan, False

    def checked(self, now: float, robot: SE2 | None, drive: DriveCommand) -> DriveCommand:
        """Return the command of this cycle, as stuck if the robot should drive and is; recovery does not end that."""
        is_driving = drive.state is DriveState.DRIVING
        if drive.state is not DriveState.RECOVERING or not self.is_stuck:
            self.update(now, robot, is_driving=is_driving)
        is_held = is_driving and self.is_stuck
        return replace(drive, state=DriveState.STUCK, detail=STUCK_DETAIL) if is_held else drive

    def update(self, now: float, robot: SE2 | None, *, is_driving: bool) -> None:
        """Take the pose at a time [s], and whether the robot should move."""
        place, since = self._place, self._since
        if place is None or robot is None or not is_driving or not now >= since:
            is_moving = True
        else:
            is_moving = place.distance_to(robot) > _DISTANCE or abs(place.yaw_to(robot)) > _ANGLE
        if is_moving:
            self._place, self._since = robot, now
        self.is_stuck = now - self._since > _TIMEOUT
