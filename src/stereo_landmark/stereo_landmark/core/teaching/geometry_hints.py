"""Checks the geometry of taught points, with the same rules for the page and the batch mode (paper 4)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from stereo_landmark.core.arrays import Floats
from stereo_landmark.core.landmark_fix import LandmarkFix, NoLandmarkFix, NoTargetDetection
from stereo_landmark.core.place.place_locator import PlaceFix
from stereo_landmark.core.primitives.primitive import Primitive
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.stereo import SpatialPoints

POINTS_RECOMMENDED = 4
"""Recommended number of points: with fewer, no point may be hidden."""
POSITION_SIGMA_MAX = 0.02
"""Recommended maximum standard deviation of the position [m]."""
YAW_SIGMA_MAX = math.radians(0.5)
"""Recommended maximum standard deviation of the yaw [rad]."""
DISTINCT_DISTANCE = 0.02
"""Minimum distance of distinct points; nearer ones, such as two rims of one meter, are hidden together [m]."""
EXTENT_MIN = 0.3
"""Recommended minimum horizontal extent of the points, for an observable yaw [m]."""


def check_geometry(positions: Floats, fix: PlaceFix | None) -> list[str]:
    """Return warnings with remedies, one line each, none for a good geometry.

    Args:
        positions: points used for the pose in the place's frame, shape (n, 3) [m].
        fix: pose at the taught place from these points, None if there is none.
    """
    warnings = [] if fix is None else _check_uncertainty(positions, fix)
    if len(positions) < POINTS_RECOMMENDED:
        return [
            *warnings,
            f'too few points: {len(positions)}, select {POINTS_RECOMMENDED} or more, since some may be hidden',
        ]
    distinct = count_distinct_points(positions)
    if distinct < POINTS_RECOMMENDED:
        warnings.append(
            f'too close together: {len(positions)} points at {distinct} distinct positions; '
            f'select points at {POINTS_RECOMMENDED} or more'
        )
    extent = horizontal_extent(positions)
    if extent < EXTENT_MIN:
        warnings.append(
            f'too narrow: the horizontal extent is {extent:.2f} m; spread them over {EXTENT_MIN} m or more'
        )
    return warnings


def count_distinct_points(positions: Floats) -> int:
    """Return the number of distinct positions of points, shape (n, 3) [m]."""
    distinct = np.empty((0, 3))
    for position in positions:
        if not (np.linalg.norm(distinct - position, axis=1) < DISTINCT_DISTANCE).any():
            distinct = np.vstack([distinct, position])
    return len(distinct)


def horizontal_extent(positions: Floats) -> float:
    """Return the horizontal extent of points, shape (n, 3) with n > 0 [m]."""
    middle = positions[:, :2] - positions[:, :2].mean(axis=0)
    return float(np.ptp(middle @ np.linalg.svd(middle)[2][0]))


def pose_sigmas(fix: PlaceFix) -> tuple[float, float]:
    """Return the standard deviations of the position in its worst direction [m] and of the yaw [rad]."""
    position = math.sqrt(float(np.linalg.eigvalsh(fix.covariance[:2, :2])[-1]))
    return position, math.sqrt(float(fix.covariance[3, 3]))


def _check_uncertainty(positions: Floats, fix: PlaceFix) -> list[str]:
    warnings = []
    position, yaw = pose_sigmas(fix)
    if position > POSITION_SIGMA_MAX:
        far = float(np.linalg.norm(positions, axis=1).mean())
        warnings.append(
            f'too shallow: at {far:.1f} m the position has a standard deviation of {100 * position:.1f} cm; '
            'select nearer points, more points, or points at another depth'
        )
    if yaw > YAW_SIGMA_MAX:
        warnings.append(
            f'the yaw has a standard deviation of {math.degrees(yaw):.1f} degrees; select points farther apart'
        )
    return warnings


SKEW_MAX = 0.05
"""Opposite sides of a rectangle differ in 3D by a smaller fraction than this,"""
SKEW_SIGMAS = 5.0
"""or by fewer standard deviations."""


def find_skewed_shapes(
    shapes: Mapping[str, Primitive], coordinates: SpatialPoints
) -> Iterator[tuple[str, str]]:
    """Yield name and warning of each quadrilateral that is not a rectangle in 3D.

    If one side is matched to another edge in one of the images, such as the frame around a panel, two corners are
    triangulated far behind or in front of the wall, with small stated covariances.

    Args:
        shapes: primitives by their names.
        coordinates: 3D points, named ``name/point``.
    """
    for name, shape in shapes.items():
        if not isinstance(shape, Quadrilateral):
            continue
        corners = coordinates.select(tuple(f'{name}/corner_{k}' for k in range(4)))
        skew, lengths = _skew(corners)
        if skew > 1.0:
            one, other = (f'{100.0 * length:.1f}' for length in lengths)
            text = (
                f'{name}: its opposite sides are {one} and {other} cm long in 3D; a rectangle is probably mismatched: '
                'select another primitive'
            )
            yield name, text


def _skew(corners: SpatialPoints) -> tuple[float, tuple[float, float]]:
    """Return the skew, above 1 for anything but a rectangle, and the lengths of the opposite sides [m]."""
    sides = [_side(corners, k) for k in range(4)]
    worst = 0.0, (0.0, 0.0)
    for (one, variance), (other, other_variance) in zip(sides[:2], sides[2:], strict=True):
        gap = abs(one - other)
        skew = min(
            gap / (SKEW_MAX * max(one, other)),
            gap / (SKEW_SIGMAS * float(np.sqrt(variance + other_variance))),
        )
        worst = max(worst, (skew, (one, other)))
    return worst


def _side(corners: SpatialPoints, k: int) -> tuple[float, float]:
    """Return the length of a side [m] and its variance [m²]."""
    other = (k + 1) % 4
    side = corners.positions[other] - corners.positions[k]
    length = float(np.linalg.norm(side))
    along = side / length
    return length, float(along @ (corners.covariances[k] + corners.covariances[other]) @ along)


def undetected_targets(answer: LandmarkFix | NoLandmarkFix) -> list[str]:
    """Return a line for each target that is not detected in the images used for teaching, by their result."""
    undetected = [
        f'target {detection.target}: {detection.reason.value} even in the taught images ({detection.detail}); '
        'add primitives that distinguish it from similar objects'
        for detection in answer.detections
        if isinstance(detection, NoTargetDetection)
    ]
    if isinstance(answer, NoLandmarkFix) and not undetected:
        undetected.append(f'{answer.reason} even in the taught images ({answer.detail}); select other points')
    return undetected
