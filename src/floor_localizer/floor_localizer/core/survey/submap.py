"""Keyframes of a drive, and submaps of consecutive ones: registered one after the other, then adjusted together."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.adjustment.bundle_adjustment import SuspensionPriors, bundle_adjust
from floor_localizer.core.survey.adjustment.observations import (
    collect_observations,
    merge_observations,
    project_observations,
)
from floor_localizer.core.survey.dot_matching import DotMatcher, MatchTolerances
from floor_localizer.core.survey.survey_image import SurveyImage
from shirube_core.geometry import SE2

# A rotation by this angle counts as much as a translation by one view width [rad].
_YAW_PER_VIEW = 1.2
_SCALE_SIGMAS, _TILT_SIGMAS = 4.0, 2.0
_FIRST_MERGE_FACTOR = 2.0
_MAX_LOOKBACK = 3


def select_keyframes(poses: Sequence[SE2], view_width: float, settings: SurveySettings) -> list[int]:
    """Return the indices of the keyframes: images that show enough new floor, according to their
    ``T_odom_base``, in views of a width [m].
    """
    chosen: list[int] = []
    for index, pose in enumerate(poses):
        if not chosen or _view_motion(poses[chosen[-1]], pose, view_width) >= settings.image_step:
            chosen.append(index)
    return chosen


def split_into_submaps(poses: Sequence[SE2], view_width: float, settings: SurveySettings) -> list[tuple[int, int]]:
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


@dataclass(frozen=True)
class Submap:
    """Submap of consecutive images.

    Attributes:
        images: indices of the images, shape (k,).
        states: states of the images as in the adjustment, shape (k, 6); the frame is the base of the first image.
        dots: positions of the dots in that frame, shape (m, 2) [m].
        counts: number of images that observed each dot, shape (m,).
        is_continuation: whether the first image is also the last one of the previous submap.
    """

    images: Ints
    states: Floats
    dots: Floats
    counts: Ints
    is_continuation: bool


def build_submap(
    images: Sequence[SurveyImage], first: int, last: int, position: Floats, settings: SurveySettings,
    *, is_continuation: bool,
) -> Submap:  # fmt: skip
    """Build a submap from consecutive images, ``first`` to ``last`` or as far as each matches one before it.

    ``position`` is the optical centre in the base frame, shape (3,) [m]; a continuation begins with the last image of
    the previous submap.
    """
    poses = [SE2(0.0, 0.0, 0.0)]
    for index in range(first + 1, last + 1):
        pose = _register_image(images, first, index, poses, float(position[2]), settings)
        if pose is None:
            break
        poses.append(pose)
    numbers = np.arange(first, first + len(poses))
    states = np.zeros((len(poses), 6))
    states[:, :3] = [(pose.x, pose.y, pose.yaw) for pose in poses]
    chosen = [images[index] for index in numbers.tolist()]
    if len(poses) == 1:
        return Submap(numbers, states, chosen[0].points, np.ones(len(chosen[0]), dtype=np.int64), is_continuation)
    priors = SuspensionPriors(position, settings.scale_sigma, settings.tilt_sigma)
    observations = collect_observations(chosen, np.arange(len(chosen)), settings.dot_sigma)
    for merge_distance in (_FIRST_MERGE_FACTOR * settings.merge_distance, settings.merge_distance):
        dot = merge_observations(
            project_observations(observations, states, position).points, observations.image, merge_distance
        )
        counts = np.bincount(dot)
        adjusted = bundle_adjust(replace(observations, dot=dot), states, np.full((len(counts), 2), np.nan), priors)
        states = adjusted.states
    return Submap(numbers, states, adjusted.dots, counts, is_continuation)


def _register_image(
    images: Sequence[SurveyImage], first: int, index: int, poses: Sequence[SE2], height: float, settings: SurveySettings
) -> SE2 | None:
    """Register an image to one of the previous images; return its pose, None if it matches none."""
    image = images[index]
    for before in range(index - 1, max(index - 1 - _MAX_LOOKBACK, first - 1), -1):
        expected = images[before].T_odom_base.inverse() @ image.T_odom_base
        found = match_images(images[before], image, expected, height, settings)
        if found is not None:
            return poses[before - first] @ found
    return None


def match_images(
    target: SurveyImage, source: SurveyImage, expected: SE2, height: float, settings: SurveySettings
) -> SE2 | None:
    """Register one image to another near the pose of its base expected from odometry; None if they do not match.

    ``height`` is that of the camera [m].
    """
    distance = float(np.hypot(expected.x, expected.y))
    radius = settings.odometry_position_tolerance + settings.odometry_error * distance
    yaw_tolerance = settings.odometry_yaw_tolerance + settings.odometry_error * (distance + abs(expected.yaw))
    # Only dots in the possible overlap of both images can match.
    spacing = 3.0 * float(np.sqrt(np.prod(np.ptp(target.points, axis=0)) / max(len(target), 1))) if len(target) else 0.0
    source_points = points_near(source.points, target.points, expected, spacing + radius)
    sigma = float(np.hypot(np.median(source.sigmas), settings.dot_sigma)) * 2.0 if len(source) else 1e-4
    tolerances = MatchTolerances(
        max(sigma, 0.0001),
        _SCALE_SIGMAS * settings.scale_sigma,
        _TILT_SIGMAS * settings.tilt_sigma / height,
        settings.chance_alignments_max,
    )
    if len(source_points) == 0 or len(target) == 0:
        return None
    found = DotMatcher(target.points).match_near(source_points, expected, radius, yaw_tolerance, tolerances)
    if found is None:
        return None
    return fit_rigid_pose(source_points[found.source], target.points[found.target])


def fit_rigid_pose(source: Floats, target: Floats) -> SE2:
    """Return the least-squares rigid motion from source dots, shape (k, 2), to their target dots."""
    z, m = source @ (1.0, 1j), target @ (1.0, 1j)
    rotation = np.vdot(z - z.mean(), m - m.mean())
    rotation /= abs(rotation)
    translation = m.mean() - rotation * z.mean()
    return SE2(float(translation.real), float(translation.imag), float(np.angle(rotation)))


def points_near(points: Floats, others: Floats, expected: SE2, max_distance: float) -> Floats:
    """Return the points, shape (n, 2), within ``max_distance`` [m] of one of the others at the expected pose."""
    if len(points) == 0 or len(others) == 0:
        return points[:0]
    distance, _ = cKDTree(others).query(expected.transform(points), distance_upper_bound=max_distance)
    return points[np.isfinite(distance)]
