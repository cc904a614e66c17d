"""Arrival at the goal: within its tolerance the robot turns to the goal's heading."""

from reward_planner.core.driving.drive_state import DriveCommand, DriveState, stop_command
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.path_following import turn_rate_for_angle
from reward_planner.core.driving.velocity_smoother import Velocity
from shirube_core.geometry import SE2

_ENTER_FACTOR = 0.7  # within this multiple of goal_tolerance the robot turns to the goal's heading
_LEAVE_FACTOR = 2.0  # beyond this multiple of goal_tolerance it drives to the goal again


class GoalArrival:
    """Whether the robot is at its goal, with hysteresis while it turns to the goal's heading."""

    def __init__(self) -> None:
        """Start before the goal."""
        self._is_at_goal = False

    def update(self, robot: SE2, goal: SE2, settings: DrivingSettings) -> DriveCommand | None:
        """Return the turn to the goal's heading, or the stop after it; None before the goal."""
        remaining = robot.yaw_to(goal)
        is_turned = abs(remaining) <= settings.goal_yaw_tolerance
        leave = 1.0 if is_turned else _LEAVE_FACTOR
        factor = leave if self._is_at_goal else _ENTER_FACTOR
        self._is_at_goal = robot.distance_to(goal) <= settings.goal_tolerance * factor
        if not self._is_at_goal:
            return None
        if is_turned:
            return stop_command(DriveState.GOAL_REACHED)
        turn = Velocity(0.0, turn_rate_for_angle(remaining, settings))
        return DriveCommand(DriveState.DRIVING, "turning to the goal's heading", turn)
