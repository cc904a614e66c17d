"""Checks the geometry of taught points, with the same rules for the page and the batch mode (paper 4)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.place_fix import PlaceFix

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


def check_geometry(positions: NDArray[np.float64], fix: PlaceFix | None) -> list[str]:
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


def count_distinct_points(positions: NDArray[np.float64]) -> int:
    """Return the number of distinct positions of points, shape (n, 3) [m]."""
    distinct = np.empty((0, 3))
    for position in positions:
        if not (np.linalg.norm(distinct - position, axis=1) < DISTINCT_DISTANCE).any():
            distinct = np.vstack([distinct, position])
    return len(distinct)


def horizontal_extent(positions: NDArray[np.float64]) -> float:
    """Return the horizontal extent of points, shape (n, 3) with n > 0 [m]."""
    middle = positions[:, :2] - positions[:, :2].mean(axis=0)
    return float(np.ptp(middle @ np.linalg.svd(middle)[2][0]))


def pose_sigmas(fix: PlaceFix) -> tuple[float, float]:
    """Return the standard deviations of the position in its worst direction [m] and of the yaw [rad]."""
    position = math.sqrt(float(np.linalg.eigvalsh(fix.covariance[:2, :2])[-1]))
    return position, math.sqrt(float(fix.covariance[3, 3]))


def _check_uncertainty(positions: NDArray[np.float64], fix: PlaceFix) -> list[str]:
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
