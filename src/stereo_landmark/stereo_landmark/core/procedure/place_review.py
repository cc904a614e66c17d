"""What is weak of a taught place, told while it can still be mended (paper 4: choose what cannot be mistaken)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer, LandmarkSettings
from stereo_landmark.core.procedure.sighting import NoTargetSighting
from stereo_landmark.core.procedure.taught_place import TaughtPlace

POINTS_GOOD = 4
"""With fewer, nothing may be hidden."""
POSITION_SIGMA_MAX = 0.02
"""[m]"""
YAW_SIGMA_MAX = math.radians(0.5)
"""[rad]"""
WIDTH_MIN = 0.3
"""Seen from above, points that are nearer together hardly tell a turn [m]."""


def review_place(
    place: TaughtPlace,
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    tilt: tuple[float, float] = (0.0, 0.0),
    settings: LandmarkSettings | None = None,
) -> list[str]:
    """Return what is weak, a line each, none for a good place.

    Args:
        place: as taught.
        left: shape (h, w), grey, rectified: what it was taught from.
        right: the same of the right camera.
        tilt: roll and pitch of the base then [rad].
        settings: how the robot will look for it; None for the defaults.
    """
    answer = LandmarkLocalizer([place], settings).locate(left, right, tilt)
    weak = [
        f'target {sighting.target}: {sighting.reason.value} even where it was taught ({sighting.detail}); '
        'add primitives that tell it from its like'
        for sighting in answer.sightings
        if isinstance(sighting, NoTargetSighting)
    ]
    if isinstance(answer, LandmarkFix):
        weak += _too_uncertain(place, answer)
    elif not weak:
        weak.append(f'{answer.reason} even where it was taught ({answer.detail}); choose other points')
    return weak + _too_few(place) + _too_narrow(place)


def _too_few(place: TaughtPlace) -> list[str]:
    count = sum(len(target.points) for target in place.targets)
    if count >= POINTS_GOOD:
        return []
    return [f'too few points: {count}, choose {POINTS_GOOD} or more, for some may be hidden']


def _too_narrow(place: TaughtPlace) -> list[str]:
    ground = _chosen_positions(place)[:, :2]
    if len(ground) < POINTS_GOOD:
        return []
    middle = ground - ground.mean(axis=0)
    width = float(np.ptp(middle @ np.linalg.svd(middle)[2][0]))
    if width >= WIDTH_MIN:
        return []
    return [
        f'too narrow: seen from above the points span {width:.2f} m; spread them over {WIDTH_MIN} m or more'
    ]


def _too_uncertain(place: TaughtPlace, fix: LandmarkFix) -> list[str]:
    weak = []
    covariance = fix.displacement.covariance
    sigma, yaw_sigma = (
        math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1])),
        math.sqrt(covariance[3, 3]),
    )
    if sigma > POSITION_SIGMA_MAX:
        far = float(np.linalg.norm(_chosen_positions(place), axis=1).mean())
        weak.append(
            f'too shallow: at {far:.1f} m the position is known to {100 * sigma:.1f} cm only; choose nearer points, '
            'more of them, or some at another depth'
        )
    if yaw_sigma > YAW_SIGMA_MAX:
        weak.append(
            f'the heading is known to {math.degrees(yaw_sigma):.1f} degrees only; choose points farther apart'
        )
    return weak


def _chosen_positions(place: TaughtPlace) -> NDArray[np.float64]:
    """Return the points that the pose is made of, shape (n, 3) [m]."""
    names = tuple(f'{target.name}/{point}' for target in place.targets for point in target.points)
    return place.coordinates.selected(names).positions
