"""Notices a robot that should drive and does not: it is stuck, held by something near, or oscillates among people."""

import math
from collections.abc import Sequence
from dataclasses import replace

from reward_planner.core.driving.drive_state import DriveCommand, DriveState
from reward_planner.core.driving.moving_obstacle_policy import MovingObstacle
from shirube_core.geometry import SE2

STUCK_DETAIL = f'{DriveState.STUCK.value}: obstacles, lamps, a monitor or the base allow no motion'
"""Detail of the state."""
_TIMEOUT = 5.0  # time without motion after which the robot is stuck [s]
_DISTANCE, _ANGLE = 0.04, 0.1  # smaller ones are the noise of the pose [m, rad]
_TURNING_TIMEOUT = 10.0  # time for which the robot may only turn [s]
_HELD_TIME, _RELEASED_DISTANCE = 1.0, 0.3  # [s], and from there [m]
_MET_DISTANCE, _MET_TIME = 2.0, 5.0  # people as near as this may hold the robot for as long [m, s]
# A robot that stays within this distance for as long, among people, oscillates [m, s].
_OSCILLATION_DISTANCE, _OSCILLATION_TIME = 0.5, 10.0
_KEEP_TIME = 7.0  # it then keeps its route for so long in each such time [s]


class StuckCheck:
    """Compares the pose with that of some seconds ago.

    Attributes:
        is_stuck: whether the robot has not moved for long.
        is_held: whether it did not move for a moment, until it has left the place.
        is_oscillating: whether it must keep its route for a while. People who come and go change the better way sooner
            than the robot turns to it, so that it would turn to and fro and never drive.
    """

    def __init__(self) -> None:
        """Start anew."""
        self.reset()

    def reset(self) -> None:
        """Start the time again."""
        self._place: SE2 | None = None
        self._held_at: SE2 | None = None
        self._met_at = -math.inf
        self._among: tuple[SE2, float] | None = None  # place among people, and since when
        self._since = self._turning_since = math.nan
        self.is_stuck = self.is_held = self.is_oscillating = False

    def note_people(self, now: float, robot: SE2, obstacles: Sequence[MovingObstacle]) -> None:
        """Take the moving obstacles at a time [s]: near them, the robot may be stopped for them."""
        has_met = 0.0 <= now - self._met_at < _MET_TIME
        if any(math.dist(each.position_at(now), (robot.x, robot.y)) < _MET_DISTANCE for each in obstacles):
            self._met_at = now
        if self._among is None or not has_met or self._among[0].distance_to(robot) > _OSCILLATION_DISTANCE:
            self._among = robot, now
        rest = now - self._among[1] - _OSCILLATION_TIME
        self.is_oscillating = rest > 0.0 and rest % _OSCILLATION_TIME < _KEEP_TIME

    def checked(self, now: float, robot: SE2 | None, drive: DriveCommand) -> DriveCommand:
        """Return the command of this cycle, as stuck if the robot should drive and is; recovery does not end that."""
        is_driving = drive.state in (DriveState.DRIVING, DriveState.GOING_AROUND)
        if drive.state is not DriveState.RECOVERING or not self.is_stuck:
            self.update(now, robot, is_driving=is_driving)
        is_held = is_driving and self.is_stuck
        return replace(drive, state=DriveState.STUCK, detail=STUCK_DETAIL) if is_held else drive

    def update(self, now: float, robot: SE2 | None, *, is_driving: bool) -> None:
        """Take the pose at a time [s], and whether the robot should move."""
        place, since = self._place, self._since
        if place is None or robot is None or not is_driving or not now >= since:
            has_left = is_moving = True
        else:
            has_left = place.distance_to(robot) > _DISTANCE
            is_moving = has_left or abs(place.yaw_to(robot)) > _ANGLE
        if is_moving and robot is not None and place is not None and not has_left:
            self._place, self._since = SE2(place.x, place.y, robot.yaw), now
        elif is_moving:
            self._place, self._since, self._turning_since = robot, now, now
        self.is_stuck = now - self._since > _TIMEOUT or now - self._turning_since > _TURNING_TIMEOUT
        if now - self._since > _HELD_TIME and not 0.0 <= now - self._met_at < _MET_TIME:
            self._held_at = robot
        held = self._held_at
        self.is_held = held is not None and robot is not None and held.distance_to(robot) < _RELEASED_DISTANCE
