"""Maps that do not fit each other."""

from reward_planner.core.reward_planner_error import RewardPlannerError


class MappingError(RewardPlannerError):
    """Cells of another size or shape than the map's, or a stamp that is not finite."""
