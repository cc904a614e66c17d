"""Which images of a drive are used, and how they are cut into pieces."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from floor_localizer.core.survey.survey_settings import SurveySettings
from shirube_geometry import PlanarPose

# A turn by this much shows as much new floor as a step of one view [rad].
_TURN = 1.2


def choose_images(poses: Sequence[PlanarPose], view_width: float, settings: SurveySettings) -> list[int]:
    """Return the indices of the images that show enough new floor, by the odometry.

    Args:
        poses: ``T_odom_base`` of all images.
        view_width: of the floor in view [m].
        settings: of the survey.
    """
    chosen: list[int] = []
    for index, pose in enumerate(poses):
        if not chosen or _moved(poses[chosen[-1]], pose, view_width) >= settings.image_step:
            chosen.append(index)
    return chosen


def cut_pieces(
    poses: Sequence[PlanarPose], view_width: float, settings: SurveySettings
) -> list[tuple[int, int]]:
    """Return first and last image of each piece; a piece ends with the image that the next one begins with."""
    cuts, since = [0], 0.0
    for index in range(1, len(poses)):
        since += _moved(poses[index - 1], poses[index], view_width)
        if since >= settings.piece_length:
            cuts.append(index)
            since = 0.0
    if cuts[-1] != len(poses) - 1 or len(cuts) == 1:
        cuts.append(len(poses) - 1)
    return list(pairwise(cuts))


def _moved(before: PlanarPose, after: PlanarPose, view_width: float) -> float:
    """Return how far the view has moved, in views."""
    return before.distance_to(after) / view_width + abs(before.turn_to(after)) / _TURN
