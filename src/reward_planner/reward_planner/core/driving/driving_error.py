"""Commands that cannot be obeyed."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class DrivingError(RewardPlannerError):
    """A command that cannot be read, a goal that is not finite, off the map or too far away."""
