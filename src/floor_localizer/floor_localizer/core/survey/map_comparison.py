"""How two dot maps of one floor differ: the rigid motion between them, what is left, what is missing or new.

Patches of one map are looked up on the other by constellations, wherever it has its origin; patches that agree on the
motion vote for it, and all dots refine it.
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
# Maps of one floor differ by less than this share of the dots' spacing, once they lie on each other.
_NEAR = 0.35
_LEAST_MATCHED = 10
_CROP = 1.0
"""Beyond the other map's dots by more than this many spacings, a dot is outside, not missing."""


@dataclass(frozen=True)
class MapComparison:
    """What two maps have in common.

    Attributes:
        T_first_second: the second map's frame in the first one's.
        scale: of the second map over the first, by the similarity that fits best.
        pairs: shape (k, 2), indices of dots of the first and of the second that are the same.
        residuals: shape (k, 2), dots of the second after the rigid motion minus those of the first [m].
        missing: indices of dots of the first, within the second's floor, that it lacks.
        extra: indices of dots of the second, within the first's floor, that the first lacks.
        outside: number of dots of either map where the other has no floor.
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
        """Root mean square distance of common dots [m]."""
        return float(np.sqrt(np.mean(np.sum(self.residuals**2, axis=1))))

    @property
    def largest(self) -> float:
        """Largest distance of common dots [m]."""
        return float(np.hypot(*self.residuals.T).max())


def compare(first: DotMap, second: DotMap) -> MapComparison:
    """Lay the second map on the first and compare them.

    Raises:
        FloorLocalizerError: they have no floor in common.
    """
    start = _start(DotField(first.points), second.points)
    if start is None:
        raise FloorLocalizerError(
            'the maps have no floor in common: no part of the second fits the first; compare maps of the same floor'
        )
    reach = _NEAR * typical_spacing(first.points)
    pose, scale = start, 1.0
    laid, under, before = np.empty(0, np.int64), np.empty(0, np.int64), -1
    for _ in range(_ROUNDS):
        # Pairs are sought under the scale, too: else, far out, a dot would be taken for its neighbour.
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
    """Return how many times larger dots, shape (k, 2), are than those they belong on, by the best similarity."""
    z, m = laid @ (1.0, 1j), under @ (1.0, 1j)
    z, m = z - z.mean(), m - m.mean()
    return float(abs(np.vdot(z, m)) / np.vdot(m, m).real)


def _start(field: DotField, points: NDArray[np.float64]) -> PlanarPose | None:
    """Return the motion that the patch with the most matched dots asks for."""
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
    """Return the dots without a partner that lie among the others, and how many lie outside."""
    alone = np.setdiff1d(np.arange(len(points)), matched)
    if len(alone) == 0:
        return alone, 0
    spacing = typical_spacing(others)
    # Among others are those with others on all sides: the middle of the nearest six is not far.
    count = min(6, len(others))
    _, nearest = cKDTree(others).query(points[alone], k=count)
    off = np.hypot(*(others[nearest].mean(axis=1) - points[alone]).T)
    inside = off < _CROP * spacing
    return alone[inside], int((~inside).sum())
