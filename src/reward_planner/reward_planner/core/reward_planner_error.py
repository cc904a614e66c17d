"""Base class of this package's exceptions.

Invalid images and cameras.

Rejected goals and commands.

Incompatible maps and frames that cannot be mapped.

Invalid points, views and voxel settings.
"""


class RewardPlannerError(ValueError):
    """Invalid input; the message is one line that names the field and the remedy."""


class DepthError(RewardPlannerError):
    """Images of a wrong type or shape, inconsistent images, or cameras that are not rectified to each other."""


class DrivingError(RewardPlannerError):
    """A malformed command, or a goal that is not finite, outside of the map or too far away."""


class MappingError(RewardPlannerError):
    """Another resolution or shape than the map's, too many cells, or an occluded frame."""


class VoxelError(RewardPlannerError):
    """Points of a wrong shape, an invalid sensor pose, or contradictory settings."""
