"""Commands that cannot be obeyed."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class DrivingError(RewardPlannerError):
    """A command of a lamp that cannot be read, or a goal that is not finite."""
