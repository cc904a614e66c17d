"""What is weak of where taught points are: one rule for the page and the batch (paper 4)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.place_fix import PlaceFix

POINTS_GOOD = 4
"""With fewer, nothing may be hidden."""
POSITION_SIGMA_MAX = 0.02
"""[m]"""
YAW_SIGMA_MAX = math.radians(0.5)
"""[rad]"""
SPOT = 0.02
"""Points that are nearer to each other, such as the centres of two rims of one meter, are hidden together [m]."""
WIDTH_MIN = 0.3
"""Seen from above, points that are nearer together hardly tell a turn [m]."""


def weak_geometry(positions: NDArray[np.float64], fix: PlaceFix | None) -> list[str]:
    """Return what is weak, a line each with its remedy, none where points are good.

    Args:
        positions: of the points that the pose is made of, shape (n, 3), in the place's frame [m].
        fix: what they tell where they were taught, None for nothing.
    """
    weak = [] if fix is None else _too_uncertain(positions, fix)
    if len(positions) < POINTS_GOOD:
        return [
            *weak,
            f'too few points: {len(positions)}, choose {POINTS_GOOD} or more, for some may be hidden',
        ]
    spots = spots_of(positions)
    if spots < POINTS_GOOD:
        weak.append(
            f'too close together: {len(positions)} points are in {spots} spots; choose some in {POINTS_GOOD} or more'
        )
    width = width_from_above(positions)
    if width < WIDTH_MIN:
        weak.append(
            f'too narrow: seen from above the points span {width:.2f} m; spread them over {WIDTH_MIN} m or more'
        )
    return weak


def spots_of(positions: NDArray[np.float64]) -> int:
    """Return in how many spots points, shape (n, 3) [m], lie."""
    spots = np.empty((0, 3))
    for position in positions:
        if not (np.linalg.norm(spots - position, axis=1) < SPOT).any():
            spots = np.vstack([spots, position])
    return len(spots)


def width_from_above(positions: NDArray[np.float64]) -> float:
    """Return how far points, shape (n, 3) with n > 0, spread along the ground [m]."""
    middle = positions[:, :2] - positions[:, :2].mean(axis=0)
    return float(np.ptp(middle @ np.linalg.svd(middle)[2][0]))


def sigmas_of(fix: PlaceFix) -> tuple[float, float]:
    """Return the standard deviations of the position, in its worst direction [m], and of the heading [rad]."""
    position = math.sqrt(float(np.linalg.eigvalsh(fix.covariance[:2, :2])[-1]))
    return position, math.sqrt(float(fix.covariance[3, 3]))


def _too_uncertain(positions: NDArray[np.float64], fix: PlaceFix) -> list[str]:
    weak = []
    position, yaw = sigmas_of(fix)
    if position > POSITION_SIGMA_MAX:
        far = float(np.linalg.norm(positions, axis=1).mean())
        weak.append(
            f'too shallow: at {far:.1f} m the position is known to {100 * position:.1f} cm only; '
            'choose nearer points, more of them, or some at another depth'
        )
    if yaw > YAW_SIGMA_MAX:
        weak.append(
            f'the heading is known to {math.degrees(yaw):.1f} degrees only; choose points farther apart'
        )
    return weak
