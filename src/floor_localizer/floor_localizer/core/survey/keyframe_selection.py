"""Select the keyframes of a drive and split them into submaps."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from floor_localizer.core.survey.survey_settings import SurveySettings
from shirube_core.geometry import SE2

# A rotation by this angle counts as much as a translation by one view width [rad].
_YAW_PER_VIEW = 1.2


def select_keyframes(poses: Sequence[SE2], view_width: float, settings: SurveySettings) -> list[int]:
    """Return the indices of the keyframes: images that show enough new floor, according to odometry.

    Args:
        poses: ``T_odom_base`` of all images.
        view_width: width of the view on the floor [m].
        settings: survey settings.
    """
    chosen: list[int] = []
    for index, pose in enumerate(poses):
        if not chosen or _view_motion(poses[chosen[-1]], pose, view_width) >= settings.image_step:
            chosen.append(index)
    return chosen


def split_into_submaps(
    poses: Sequence[SE2], view_width: float, settings: SurveySettings
) -> list[tuple[int, int]]:
    """Return first and last image of each submap; consecutive submaps share an image."""
    cuts, distance = [0], 0.0
    for index in range(1, len(poses)):
        distance += _view_motion(poses[index - 1], poses[index], view_width)
        if distance >= settings.submap_length:
            cuts.append(index)
            distance = 0.0
    if cuts[-1] != len(poses) - 1 or len(cuts) == 1:
        cuts.append(len(poses) - 1)
    return list(pairwise(cuts))


def _view_motion(before: SE2, after: SE2, view_width: float) -> float:
    """Return the motion of the view, in view widths."""
    return before.distance_to(after) / view_width + abs(before.yaw_to(after)) / _YAW_PER_VIEW
