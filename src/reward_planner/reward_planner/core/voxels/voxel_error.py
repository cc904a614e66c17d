"""Invalid points, views and voxel settings."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class VoxelError(RewardPlannerError):
    """Points of a wrong shape, an invalid sensor pose, or contradictory settings."""
