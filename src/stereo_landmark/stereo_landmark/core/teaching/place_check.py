"""Checks a taught place for weak geometry and ambiguous targets (paper 4: targets must be unique)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix, NoTargetDetection
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.procedure.taught_place import TaughtPlace
from stereo_landmark.core.settings import LandmarkSettings
from stereo_landmark.core.teaching.geometry_hints import check_geometry


def check_place(
    place: TaughtPlace,
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    tilt: tuple[float, float] = (0.0, 0.0),
    settings: LandmarkSettings | None = None,
) -> list[str]:
    """Return warnings, one line each, none for a good place.

    Args:
        place: taught place.
        left: rectified grey left image used for teaching, shape (h, w).
        right: rectified grey right image used for teaching, shape (h, w).
        tilt: roll and pitch of the base at teaching time [rad].
        settings: localization settings; None for the defaults.
    """
    answer = LandmarkLocalizer([place], settings).locate(left, right, tilt)
    fix = answer.displacement if isinstance(answer, LandmarkFix) else None
    return undetected_targets(answer) + check_geometry(_pose_point_positions(place), fix)


def undetected_targets(answer: LandmarkFix | NoLandmarkFix) -> list[str]:
    """Return a line for each target that is not detected in the images used for teaching.

    Args:
        answer: localization result for those images.
    """
    undetected = [
        f'target {detection.target}: {detection.reason.value} even in the taught images ({detection.detail}); '
        'add primitives that distinguish it from similar objects'
        for detection in answer.detections
        if isinstance(detection, NoTargetDetection)
    ]
    if isinstance(answer, NoLandmarkFix) and not undetected:
        undetected.append(f'{answer.reason} even in the taught images ({answer.detail}); select other points')
    return undetected


def _pose_point_positions(place: TaughtPlace) -> NDArray[np.float64]:
    """Return the points used for the pose, shape (n, 3) [m]."""
    names = tuple(f'{target.name}/{point}' for target in place.targets for point in target.points)
    return place.coordinates.select(names).positions
