"""Compare two dot maps of one floor: the rigid motion between them, residuals, missing and extra dots.

Patches of one map are matched in the other by constellations, independent of the origins; the patch whose motion
matches most dots gives the first estimate, and all dots refine it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.dot_grid import typical_spacing
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.dot_matching import DotField, Matched, Tolerances, nearest_pairs
from floor_localizer.core.survey.piece import rigid_pose
from shirube_geometry import PlanarPose

_PATCH_DOTS, _PATCHES = 60, 25
_SIGMA, _SCALE, _CHANCE = 0.0003, 0.05, 1e-6
_ROUNDS = 20
# Largest distance of matched dots after registration, as a fraction of the dot spacing.
_NEAR = 0.35
_LEAST_MATCHED = 10
_CROP = 1.0
"""A dot farther than this many spacings beyond the other map's dots is outside, not missing."""


@dataclass(frozen=True)
class MapComparison:
    """Result of comparing two maps.

    Attributes:
        T_first_second: pose of the second map's frame in the first one's.
        scale: scale of the second map relative to the first, from the best similarity.
        pairs: indices of matched dots of the first and the second map, shape (k, 2).
        residuals: dots of the second map after the rigid motion minus those of the first, shape (k, 2) [m].
        missing: indices of dots of the first map that are missing in the second, within its area.
        extra: indices of dots of the second map that are missing in the first, within its area.
        outside: number of dots of either map outside the area of the other.
    """

    T_first_second: PlanarPose
    scale: float
    pairs: NDArray[np.int64]
    residuals: NDArray[np.float64]
    missing: NDArray[np.int64]
    extra: NDArray[np.int64]
    outside: int

    @property
    def rms(self) -> float:
        """Root mean square distance of matched dots [m]."""
        return float(np.sqrt(np.mean(np.sum(self.residuals**2, axis=1))))

    @property
    def largest(self) -> float:
        """Largest distance of matched dots [m]."""
        return float(np.hypot(*self.residuals.T).max())


def compare(first: DotMap, second: DotMap) -> MapComparison:
    """Register the second map to the first and compare them.

    Raises:
        FloorLocalizerError: the maps do not overlap.
    """
    start = _start(DotField(first.points), second.points)
    if start is None:
        raise FloorLocalizerError(
            'the maps do not overlap: no part of the second matches the first; compare maps of the same floor'
        )
    reach = _NEAR * typical_spacing(first.points)
    pose, scale = start, 1.0
    laid, under, before = np.empty(0, np.int64), np.empty(0, np.int64), -1
    for _ in range(_ROUNDS):
        # Pairs are matched with the scale applied; without it, a distant dot would be matched to its neighbour.
        laid, under = nearest_pairs(first.points, pose.transform(second.points / scale), reach)
        if len(laid) < _LEAST_MATCHED:
            raise FloorLocalizerError('the maps have too few dots in common; compare maps of the same floor')
        scale = _scale(second.points[laid], first.points[under])
        pose = rigid_pose(second.points[laid] / scale, first.points[under])
        if len(laid) == before:
            break
        before = len(laid)
    pose = rigid_pose(second.points[laid], first.points[under])
    placed = pose.transform(second.points)
    missing, outside_first = _unmatched(first.points, under, placed)
    extra, outside_second = _unmatched(placed, laid, first.points)
    return MapComparison(
        pose, scale, np.column_stack([under, laid]), placed[laid] - first.points[under],
        missing, extra, outside_first + outside_second,
    )  # fmt: skip


def _scale(laid: NDArray[np.float64], under: NDArray[np.float64]) -> float:
    """Return the scale of source dots, shape (k, 2), relative to their target dots, by the best similarity."""
    z, m = laid @ (1.0, 1j), under @ (1.0, 1j)
    z, m = z - z.mean(), m - m.mean()
    return float(abs(np.vdot(z, m)) / np.vdot(m, m).real)


def _start(field: DotField, points: NDArray[np.float64]) -> PlanarPose | None:
    """Return the motion of the patch with the most matched dots."""
    tree, best = cKDTree(points), None
    by = Tolerances(_SIGMA, _SCALE, 0.0, _CHANCE)
    seeds = np.linspace(0, len(points) - 1, min(_PATCHES, len(points))).astype(int)
    for seed in seeds:
        patch = points[tree.query(points[seed], k=min(_PATCH_DOTS, len(points)))[1]]
        middle = patch.mean(axis=0)
        found = field.match_anywhere(patch - middle, by)
        if found is not None:
            pose = _about_origin(found, middle)
            votes = len(nearest_pairs(field.points, pose.transform(points), 10.0 * _SIGMA)[0])
            if best is None or votes > best[0]:
                best = (votes, pose)
    return None if best is None else best[1]


def _about_origin(found: Matched, middle: NDArray[np.float64]) -> PlanarPose:
    turn = found.turn / abs(found.turn)
    shift = found.shift - turn * complex(*middle)
    return PlanarPose(shift.real, shift.imag, math.atan2(turn.imag, turn.real))


def _unmatched(
    points: NDArray[np.float64], matched: NDArray[np.int64], others: NDArray[np.float64]
) -> tuple[NDArray[np.int64], int]:
    """Return the unmatched dots within the area of the others, and the number outside it."""
    alone = np.setdiff1d(np.arange(len(points)), matched)
    if len(alone) == 0:
        return alone, 0
    spacing = typical_spacing(others)
    # Inside the area the six nearest dots surround a dot, so their centroid is near it.
    count = min(6, len(others))
    _, nearest = cKDTree(others).query(points[alone], k=count)
    off = np.hypot(*(others[nearest].mean(axis=1) - points[alone]).T)
    inside = off < _CROP * spacing
    return alone[inside], int((~inside).sum())
