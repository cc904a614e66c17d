"""Incompatible maps and frames that cannot be mapped."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class MappingError(RewardPlannerError):
    """Another resolution or shape than the map's, too many cells, or an occluded frame."""
