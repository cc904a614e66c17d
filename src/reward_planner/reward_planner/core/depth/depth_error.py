"""Images and cameras that no depth can be computed from."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class DepthError(RewardPlannerError):
    """Images of a wrong type or shape, or cameras that are not rectified to each other."""
