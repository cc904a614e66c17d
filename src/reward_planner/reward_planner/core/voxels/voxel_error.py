"""Points, views and settings that no voxels can be made of."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class VoxelError(RewardPlannerError):
    """Points of a wrong shape, a view that is no pose, or settings that contradict each other."""
