"""Compare two dot maps of one floor: the rigid motion between them, residuals, missing and extra dots.

Patches of one map are matched in the other by constellations, independent of the origins; the patch whose motion
matches most dots gives the first estimate, and all dots refine it.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.constellation.dot_grid import typical_spacing
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.survey.dot_matching import DotMatch, DotMatcher, MatchTolerances, nearest_pairs
from floor_localizer.core.survey.submap import fit_rigid_pose
from shirube_core.geometry import SE2

_PATCH_DOTS, _PATCHES = 60, 25
_SIGMA, _SCALE, _CHANCE_ALIGNMENTS_MAX = 0.0003, 0.05, 1e-6
_ROUNDS = 20
# Largest distance of matched dots after registration, as a fraction of the dot spacing.
_MAX_DISTANCE_FRACTION = 0.35
_MIN_MATCHED = 10
_AREA_MARGIN = 1.0  # a dot farther than this many spacings beyond the other map's dots is outside, not missing


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

    T_first_second: SE2
    scale: float
    pairs: Ints
    residuals: Floats
    missing: Ints
    extra: Ints
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
    """Register the second map to the first and compare them; raise a FloorLocalizerError if they do not overlap."""
    start = _initial_motion(DotMatcher(first.points), second.points)
    if start is None:
        raise FloorLocalizerError(
            'the maps do not overlap: no part of the second matches the first; compare maps of the same floor'
        )
    max_distance = _MAX_DISTANCE_FRACTION * typical_spacing(first.points)
    pose, scale = start, 1.0
    source, target, before = np.empty(0, np.int64), np.empty(0, np.int64), -1
    for _ in range(_ROUNDS):
        # Pairs are matched with the scale applied; without it, a distant dot would be matched to its neighbour.
        source, target = nearest_pairs(first.points, pose.transform(second.points / scale), max_distance)
        if len(source) < _MIN_MATCHED:
            raise FloorLocalizerError('the maps have too few dots in common; compare maps of the same floor')
        scale = _scale(second.points[source], first.points[target])
        pose = fit_rigid_pose(second.points[source] / scale, first.points[target])
        if len(source) == before:
            break
        before = len(source)
    pose = fit_rigid_pose(second.points[source], first.points[target])
    transformed = pose.transform(second.points)
    missing, outside_first = _unmatched(first.points, target, transformed)
    extra, outside_second = _unmatched(transformed, source, first.points)
    return MapComparison(
        pose, scale, np.column_stack([target, source]), transformed[source] - first.points[target],
        missing, extra, outside_first + outside_second,
    )  # fmt: skip


def _scale(source: Floats, target: Floats) -> float:
    """Return the scale of source dots, shape (k, 2), relative to their target dots, by the best similarity."""
    z, m = source @ (1.0, 1j), target @ (1.0, 1j)
    z, m = z - z.mean(), m - m.mean()
    return float(abs(np.vdot(z, m)) / np.vdot(m, m).real)


def _initial_motion(matcher: DotMatcher, points: Floats) -> SE2 | None:
    """Return the motion of the patch with the most matched dots."""
    tree, best = cKDTree(points), None
    tolerances = MatchTolerances(_SIGMA, _SCALE, 0.0, _CHANCE_ALIGNMENTS_MAX)
    seeds = np.linspace(0, len(points) - 1, min(_PATCHES, len(points))).astype(int)
    for seed in seeds:
        patch = points[tree.query(points[seed], k=min(_PATCH_DOTS, len(points)))[1]]
        centroid = patch.mean(axis=0)
        found = matcher.match_anywhere(patch - centroid, tolerances)
        if found is not None:
            pose = _relative_to_origin(found, centroid)
            votes = len(nearest_pairs(matcher.points, pose.transform(points), 10.0 * _SIGMA)[0])
            if best is None or votes > best[0]:
                best = (votes, pose)
    return None if best is None else best[1]


def _relative_to_origin(found: DotMatch, centroid: Floats) -> SE2:
    rotation = found.rotation / abs(found.rotation)
    translation = found.translation - rotation * complex(*centroid)
    return SE2(translation.real, translation.imag, math.atan2(rotation.imag, rotation.real))


def _unmatched(points: Floats, matched: Ints, others: Floats) -> tuple[Ints, int]:
    """Return the unmatched dots within the area of the others, and the number outside it."""
    unmatched = np.setdiff1d(np.arange(len(points)), matched)
    if len(unmatched) == 0:
        return unmatched, 0
    spacing = typical_spacing(others)
    # Inside the area the six nearest dots surround a dot, so their centroid is near it.
    count = min(6, len(others))
    _, nearest = cKDTree(others).query(points[unmatched], k=count)
    offset = np.hypot(*(others[nearest].mean(axis=1) - points[unmatched]).T)
    inside = offset < _AREA_MARGIN * spacing
    return unmatched[inside], int((~inside).sum())
