"""Result of localization: a pose with its quality, or the reason for no pose."""

from dataclasses import dataclass
from enum import Enum

from floor_localizer.core.arrays import Booleans, Floats
from floor_localizer.core.dots import DetectedDots
from shirube_core.geometry import SE2


@dataclass(frozen=True)
class PosePrior:
    """Prior: the expected pose with its tolerances.

    Attributes:
        T_map_base: expected pose.
        radius: maximum distance of the robot from it [m].
        yaw_tolerance: maximum difference from its yaw [rad]; pi if the yaw is unknown.
        is_strict: whether poses outside are rejected (an initial pose from the user); else the whole map is searched if
            there is no pose inside (a prediction from the last pose, which is wrong after a kidnapping).
    """

    T_map_base: SE2
    radius: float
    yaw_tolerance: float
    is_strict: bool = False

    def contains(self, pose: SE2) -> bool:
        """Return whether a pose is within the tolerances."""
        expected = self.T_map_base
        return pose.distance_to(expected) <= self.radius and abs(pose.yaw_to(expected)) <= self.yaw_tolerance


@dataclass(frozen=True)
class Fix:
    """A pose.

    Attributes:
        T_map_base: pose of the robot.
        covariance: shape (3, 3), covariance of x, y [m] and yaw [rad].
        dots: dots in view.
        matched: shape (n,), whether each dot was matched to the map.
        map_points: shape (n, 2), matched map dots [m], NaN for unmatched dots.
        match_rate: fraction of the dots that were matched.
        scale: relative height error of the camera: height over mounted height, minus one.
        tilt: roll and pitch of the robot [rad].
        expected_chance_alignments: expected number of equally good poses by chance (see `acceptance`).
        used_prior: whether the pose was found within the prior.
        level: name of the floor level in whose frame pose and map dots are; empty for the frame of the whole map.
    """

    T_map_base: SE2
    covariance: Floats
    dots: DetectedDots
    matched: Booleans
    map_points: Floats
    match_rate: float
    scale: float
    tilt: tuple[float, float]
    expected_chance_alignments: float
    used_prior: bool
    level: str = ''


class NoFixReason(Enum):
    """Why there is no pose."""

    NO_DOTS = 'no dots on the floor'
    TOO_FEW_DOTS = 'too few dots'
    NO_MATCH = 'the dots match no place of the map'
    MIRRORED = 'the dots match the map only mirrored: is the image or the map flipped?'
    AMBIGUOUS = 'the dots match several places of the map'
    UNCERTAIN = 'the best match could be chance'
    OUTSIDE_AREA = 'the dots match no place within the prior'


@dataclass(frozen=True)
class NoFix:
    """No pose, with the reason.

    Attributes:
        reason: kind of failure.
        detail: figures for the diagnostics.
        dots: dots in view, None if the image was not processed.
    """

    reason: NoFixReason
    detail: str
    dots: DetectedDots | None = None
