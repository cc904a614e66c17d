"""Invalid images and cameras."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class DepthError(RewardPlannerError):
    """Images of a wrong type or shape, inconsistent images, or cameras that are not rectified to each other."""
