"""What is weak of a taught place, told while it can still be mended (paper 4: choose what cannot be mistaken)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer, LandmarkSettings
from stereo_landmark.core.procedure.sighting import NoTargetSighting
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.procedure.weak_geometry import weak_geometry


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
    fix = answer.displacement if isinstance(answer, LandmarkFix) else None
    return not_found_again(answer) + weak_geometry(_chosen_positions(place), fix)


def not_found_again(answer: LandmarkFix | NoLandmarkFix) -> list[str]:
    """Return what is not found in the very images that it was taught from, a line each.

    Args:
        answer: of the localizer to those images.
    """
    lost = [
        f'target {sighting.target}: {sighting.reason.value} even where it was taught ({sighting.detail}); '
        'add primitives that tell it from its like'
        for sighting in answer.sightings
        if isinstance(sighting, NoTargetSighting)
    ]
    if isinstance(answer, NoLandmarkFix) and not lost:
        lost.append(f'{answer.reason} even where it was taught ({answer.detail}); choose other points')
    return lost


def _chosen_positions(place: TaughtPlace) -> NDArray[np.float64]:
    """Return the points that the pose is made of, shape (n, 3) [m]."""
    names = tuple(f'{target.name}/{point}' for target in place.targets for point in target.points)
    return place.coordinates.selected(names).positions
