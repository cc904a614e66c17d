"""Rejected goals and commands."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class DrivingError(RewardPlannerError):
    """A malformed command, or a goal that is not finite, outside of the map or too far away."""
