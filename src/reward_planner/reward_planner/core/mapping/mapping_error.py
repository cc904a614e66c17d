"""Maps that do not fit each other, and frames of which none can be made."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class MappingError(RewardPlannerError):
    """Cells of another size or shape than the map's, more of them than it keeps, or a frame that tells nothing."""
