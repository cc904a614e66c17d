"""Commands that cannot be obeyed."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class DrivingError(RewardPlannerError):
    """A command of a lamp that cannot be read, a goal that is not finite or off the map, or too large an area."""
