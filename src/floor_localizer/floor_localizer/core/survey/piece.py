"""A submap of consecutive images: registered one after the other, then adjusted together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.survey.adjustment import BodyPriors, adjust
from floor_localizer.core.survey.dot_matching import DotField, Tolerances
from floor_localizer.core.survey.placed_sightings import placed, sightings_of
from floor_localizer.core.survey.sightings import merge_sightings
from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.core.survey.survey_settings import SurveySettings
from shirube_geometry import PlanarPose

_SCALE_SIGMAS, _TILT_SIGMAS = 4.0, 2.0
_FIRST_REACH = 2.0
_BACK = 3


@dataclass(frozen=True)
class Piece:
    """Submap of consecutive images.

    Attributes:
        images: indices of the images, shape (k,).
        states: states of the images as in the adjustment, shape (k, 6); the frame is the base of the first image.
        dots: positions of the dots in that frame, shape (m, 2) [m].
        counts: number of images that observed each dot, shape (m,).
        is_linked: whether the first image is also the last one of the previous submap.
    """

    images: NDArray[np.int64]
    states: NDArray[np.float64]
    dots: NDArray[np.float64]
    counts: NDArray[np.int64]
    is_linked: bool


def build_piece(
    images: Sequence[SurveyImage], first: int, last: int, position: NDArray[np.float64], settings: SurveySettings,
    *, is_linked: bool,
) -> Piece:  # fmt: skip
    """Build a submap from consecutive images as long as they overlap.

    Args:
        images: all images of the survey.
        first: index of the first image.
        last: index of the last image; the submap ends earlier where an image matches none before it.
        position: optical centre in the base frame, shape (3,) [m].
        settings: survey settings.
        is_linked: whether the first image is also the last one of the previous submap.
    """
    poses = [PlanarPose(0.0, 0.0, 0.0)]
    for index in range(first + 1, last + 1):
        pose = _beside(images, first, index, poses, float(position[2]), settings)
        if pose is None:
            break
        poses.append(pose)
    numbers = np.arange(first, first + len(poses))
    states = np.zeros((len(poses), 6))
    states[:, :3] = [(pose.x, pose.y, pose.yaw) for pose in poses]
    chosen = [images[index] for index in numbers.tolist()]
    if len(poses) == 1:
        return Piece(numbers, states, chosen[0].points, np.ones(len(chosen[0]), dtype=np.int64), is_linked)
    priors = BodyPriors(position, settings.scale_sigma, settings.tilt_sigma)
    seen = sightings_of(chosen, np.arange(len(chosen)), settings.dot_sigma)
    for merge_distance in (_FIRST_REACH * settings.same_dot, settings.same_dot):
        dot = merge_sightings(placed(seen, states, position).points, seen.image, merge_distance)
        counts = np.bincount(dot)
        adjusted = adjust(replace(seen, dot=dot), states, np.full((len(counts), 2), np.nan), priors)
        states = adjusted.states
    return Piece(numbers, states, adjusted.dots, counts, is_linked)


def _beside(
    images: Sequence[SurveyImage],
    first: int,
    index: int,
    poses: Sequence[PlanarPose],
    height: float,
    settings: SurveySettings,
) -> PlanarPose | None:
    """Register an image to one of the previous images; return its pose, None if it matches none."""
    image = images[index]
    for before in range(index - 1, max(index - 1 - _BACK, first - 1), -1):
        expected = images[before].T_odom_base.inverse() @ image.T_odom_base
        found = match_images(images[before], image, expected, height, settings)
        if found is not None:
            return poses[before - first] @ found
    return None


def match_images(
    under: SurveyImage, laid: SurveyImage, expected: PlanarPose, height: float, settings: SurveySettings
) -> PlanarPose | None:
    """Register one image to another near the pose expected from odometry; None if they do not match.

    Args:
        under: target image.
        laid: source image.
        expected: expected pose of the source base in the target base.
        height: camera height [m].
        settings: survey settings.
    """
    way = float(np.hypot(expected.x, expected.y))
    radius = settings.odometry_radius + settings.odometry_error * way
    yaw_tolerance = settings.odometry_turn + settings.odometry_error * (way + abs(expected.yaw))
    # Only dots in the possible overlap of both images can match.
    spacing = (
        3.0 * float(np.sqrt(np.prod(np.ptp(under.points, axis=0)) / max(len(under), 1)))
        if len(under)
        else 0.0
    )
    laid_points = overlapping(laid.points, under.points, expected, spacing + radius)
    sigma = float(np.hypot(np.median(laid.sigmas), settings.dot_sigma)) * 2.0 if len(laid) else 1e-4
    by = Tolerances(
        max(sigma, 0.0001),
        _SCALE_SIGMAS * settings.scale_sigma,
        _TILT_SIGMAS * settings.tilt_sigma / height,
        settings.chance,
    )
    if len(laid_points) == 0 or len(under) == 0:
        return None
    found = DotField(under.points).match_near(laid_points, expected, radius, yaw_tolerance, by)
    if found is None:
        return None
    return rigid_pose(laid_points[found.laid], under.points[found.under])


def rigid_pose(laid: NDArray[np.float64], under: NDArray[np.float64]) -> PlanarPose:
    """Return the least-squares rigid motion from source dots, shape (k, 2), to their target dots."""
    z, m = laid @ (1.0, 1j), under @ (1.0, 1j)
    turn = np.vdot(z - z.mean(), m - m.mean())
    turn /= abs(turn)
    shift = m.mean() - turn * z.mean()
    return PlanarPose(float(shift.real), float(shift.imag), float(np.angle(turn)))


def overlapping(
    points: NDArray[np.float64], others: NDArray[np.float64], expected: PlanarPose, reach: float
) -> NDArray[np.float64]:
    """Return the points, shape (n, 2), within ``reach`` [m] of one of the others at the expected pose."""
    if len(points) == 0 or len(others) == 0:
        return points[:0]
    distance, _ = cKDTree(others).query(expected.transform(points), distance_upper_bound=reach)
    return points[np.isfinite(distance)]
