"""Exceptions of this package."""


class RewardPlannerError(ValueError):
    """Invalid input; the message is one line that names the field and the remedy."""


class DrivingError(RewardPlannerError):
    """A malformed command, or a goal that is not finite, outside of the map or too far away."""
