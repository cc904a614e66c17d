"""What localization answers: a pose with its evidence, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.detected_dots import DetectedDots
from shirube_geometry import PlanarPose


@dataclass(frozen=True)
class PosePrior:
    """Where the robot is expected.

    Attributes:
        T_map_base: the expected pose.
        radius: the robot is no farther from it than this [m].
        turn: and its heading is no farther off than this [rad]; pi where nothing is known.
        must_hold: whether a pose elsewhere is refused (an area given from outside), or looked for when there
            is none here (an expectation from the last pose, which a kidnapping breaks).
    """

    T_map_base: PlanarPose
    radius: float
    turn: float
    must_hold: bool = False


@dataclass(frozen=True)
class Fix:
    """A pose.

    Attributes:
        T_map_base: the robot's pose.
        covariance: shape (3, 3), of x, y [m] and yaw [rad].
        dots: the dots in view.
        matched: shape (n,), which of them were found on the map.
        map_points: shape (n, 2), the map dots they were matched with [m], NaN where there is none.
        match_rate: share of the dots that were found.
        scale: height of the camera over its mounted height, less one.
        tilt: roll and pitch of the robot [rad].
        expected_chance_alignments: how many poses as good as this are expected by chance (see `acceptance`).
        used_prior: whether the pose was found near where it was expected.
        sheet: name of the floor in whose frame pose and map dots are; empty for the frame of the whole map.
    """

    T_map_base: PlanarPose
    covariance: NDArray[np.float64]
    dots: DetectedDots
    matched: NDArray[np.bool_]
    map_points: NDArray[np.float64]
    match_rate: float
    scale: float
    tilt: tuple[float, float]
    expected_chance_alignments: float
    used_prior: bool
    sheet: str = ''


class NoFixReason(Enum):
    """Why there is no pose."""

    NO_DOTS = 'no dots on the floor'
    TOO_FEW_DOTS = 'too few dots'
    NO_MATCH = 'the dots match no place of the map'
    MIRRORED = 'the dots match the map only mirrored: is the image or the map flipped?'
    AMBIGUOUS = 'the dots match several places of the map'
    UNCERTAIN = 'the best match could be chance'
    OUTSIDE_AREA = 'the dots match no place of the given area'


@dataclass(frozen=True)
class NoFix:
    """No pose, and why.

    Attributes:
        reason: the kind of failure.
        detail: numbers to it, for the diagnostics.
        dots: the dots in view, None where the image gave none to look at.
    """

    reason: NoFixReason
    detail: str
    dots: DetectedDots | None = None
