"""Build the pose graph: edges between consecutive submaps, neighbouring lanes, and loop closures.

Each new submap is placed by the odometry of its first image and registered to the submaps it may overlap. If the drift
since the last loop closure is too large, it is searched in all earlier dots by constellations. Matches that may be
chance are rejected.
"""

from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from floor_localizer.core.arrays import Complexes, Floats, Ints
from floor_localizer.core.settings import SurveySettings
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.dot_matching import DotMatch, DotMatcher, MatchTolerances, nearest_pairs
from floor_localizer.core.survey.submap import Submap, points_near
from floor_localizer.core.survey.submap_graph.pose_graph import DOT_SIGMA, PoseGraphEdge, SubmapPoses
from floor_localizer.core.survey.survey_image import SurveyImage
from shirube_core.geometry import SE2

_CACHE_SIZE = 64


class SubmapMatchers:
    """Dot matchers of all submaps, each in its own frame, with an LRU cache."""

    def __init__(self, store: ArrayStore) -> None:
        """Begin without a submap."""
        self._store = store
        self._cache: OrderedDict[int, DotMatcher] = OrderedDict()
        # Lower and upper corner of each submap, with spare capacity.
        self._corners = np.empty((_CACHE_SIZE, 2, 2))
        self._count = 0

    def append(self, dots: Floats) -> None:
        """Add the dots of the next submap, shape (n, 2) [m], n >= 1."""
        if self._count == len(self._corners):
            self._corners = np.concatenate([self._corners, np.empty_like(self._corners)])
        self._store.put('submap', self._count, dots)
        self._corners[self._count] = dots.min(axis=0), dots.max(axis=0)
        self._count += 1

    def dots(self, index: int) -> Floats:
        """Return the dots of a submap, shape (n, 2) [m]."""
        (dots,) = self._store.get('submap', index)
        return dots

    def __getitem__(self, index: int) -> DotMatcher:
        """Return the matcher of a submap."""
        if index not in self._cache:
            self._cache[index] = DotMatcher(self.dots(index))
            if len(self._cache) > _CACHE_SIZE:
                self._cache.popitem(last=False)
        self._cache.move_to_end(index)
        return self._cache[index]

    def may_overlap(self, index: int, other: int, pose: SE2, radius: float) -> bool:
        """Return whether the bounding boxes of two submaps may overlap, given the pose of the first in the
        frame of the other and the uncertainty of its position [m].
        """
        transformed, (lower, upper) = pose.transform(self[index].points), self._corners[other]
        return bool(
            (transformed.min(axis=0) - radius < upper).all() and (transformed.max(axis=0) + radius > lower).all()
        )

    def overlap_candidates(self, index: int, rotations: Complexes, translations: Complexes, radius: float) -> Ints:
        """Return a superset of the submaps for which `may_overlap` is true, by bounding circles.

        ``rotations``, shape (n,), are complex and of magnitude 1, ``translations`` are complex, shape (n,) [m].
        """
        lower, upper = (self._corners[: self._count] @ (1.0, 1j)).T
        centres, sizes = rotations * (0.5 * (lower + upper)) + translations, 0.5 * np.abs(upper - lower)
        # The bounding box of a rotated box is larger than its bounding circle.
        radii = np.sqrt(2.0) * (sizes[index] + radius) + sizes
        return np.flatnonzero(np.abs(centres - centres[index]) <= 1.0001 * radii)


_SCALE_TOLERANCE = 0.02
_MIN_SHARED_DOTS = 6
# Drift of the image chain and of odometry per distance driven; largest search radius [m] and yaw tolerance [rad].
_DRIFT, _ODOMETRY_DRIFT, _MAX_RADIUS, _MAX_YAW_TOLERANCE = 0.02, 0.1, 0.12, 0.4
# Yaw tolerance without drift [rad], and its relative growth per metre of drift [1/m].
_YAW_TOLERANCE, _YAW_GROWTH = 0.02, 20.0
# Search radius if the position is known from a shared image, and from another edge [m].
_IMAGE_RADIUS, _EDGE_RADIUS = 0.003, 0.004
# Two submaps share the dots that are within this many standard deviations.
_SHARED_GATE = 5.0
# Margin of the possible overlap of two submaps, in grid cells.
_OVERLAP_MARGIN_CELLS = 2.5
_GLOBAL_CHANCE_FACTOR = 1e-3  # a global match must be less likely by chance by this factor


class PoseGraphBuilder:
    """Adds submaps to the pose graph one after the other.

    Attributes:
        submaps: submaps so far, without their dots, which are in the array store.
        poses: poses of the submaps, and the edges between them.
    """

    def __init__(
        self, images: Sequence[SurveyImage], settings: SurveySettings, existing: Floats | None, store: ArrayStore
    ) -> None:
        """Begin with an empty graph, or with the dots of the map to extend, shape (n, 2) [m], as submap 0."""
        self._images, self._settings = images, settings
        self.submaps: list[Submap] = []
        self.poses = SubmapPoses()
        self._matchers = SubmapMatchers(store)
        self._drift: list[float] = []
        self._all_dots: tuple[int, DotMatcher, Ints] | None = None
        if existing is not None:
            old = Submap(np.empty(0, dtype=np.int64), np.empty((0, 6)), existing, np.empty(0, dtype=np.int64), False)
            self._append(old, 1.0 + 0.0j, 0.0j, 0.0)

    def add(self, submap: Submap) -> None:
        """Add the next submap and its edges."""
        index = len(self.submaps)
        rotation, translation, drift = self._predict_pose(submap)
        self._append(submap, rotation, translation, drift)
        if index == 0:
            return
        new = [*self._sequential_edge(index), *self._nearby_edges(index)]
        if not any(edge.is_loop_closure for edge in new) and (drift >= _MAX_RADIUS or not new):
            new += self._global_edges(index)
        if any(edge.is_loop_closure for edge in new):
            self._drift[index] = 0.0
        self.poses.add_edges(new)

    def _append(self, submap: Submap, rotation: complex, translation: complex, drift: float) -> None:
        self._matchers.append(submap.dots)
        self.submaps.append(replace(submap, dots=submap.dots[:0].copy(), counts=submap.counts[:0].copy()))
        self._drift.append(drift)
        self.poses.append(rotation, translation)

    def _predict_pose(self, submap: Submap) -> tuple[complex, complex, float]:
        """Return the pose of a submap predicted from the previous one, and its drift [m]."""
        if not self.submaps or len(self.submaps[-1].images) == 0:
            # The first submap may be anywhere on the map to extend.
            return 1.0 + 0.0j, 0.0j, _MAX_RADIUS if self.submaps else 0.0
        before = self.submaps[-1]
        last = before.images[-1]
        x, y, yaw = (float(value) for value in before.states[-1, :3])
        step = self._images[last].T_odom_base.inverse() @ self._images[submap.images[0]].T_odom_base
        pose = SE2(x, y, yaw) @ step
        a = self.poses.rotations[-1] / abs(self.poses.rotations[-1])
        rotation = a * complex(np.exp(1j * pose.yaw))
        translation = self.poses.rotations[-1] * complex(pose.x, pose.y) + self.poses.translations[-1]
        drift = self._drift[-1] + _DRIFT * float(np.sum(np.hypot(*np.diff(before.states[:, :2], axis=0).T)))
        if not submap.is_continuation:
            gap = float(np.hypot(step.x, step.y))
            drift += self._settings.odometry_position_tolerance + gap * _ODOMETRY_DRIFT
        return rotation, translation, drift

    def _pose(self, index: int) -> SE2:
        translation = self.poses.translations[index]
        return SE2(translation.real, translation.imag, float(np.angle(self.poses.rotations[index])))

    def _sequential_edge(self, index: int) -> Iterator[PoseGraphEdge]:
        """Yield the edge to the previous submap, from the dots of the image that both contain."""
        if not self.submaps[index].is_continuation or len(self.submaps[index - 1].images) == 0:
            return
        found = self._match_submap(index, index - 1, _IMAGE_RADIUS, _YAW_TOLERANCE)
        if found is not None:
            yield self._make_edge(index, index - 1, found, is_loop_closure=False)

    def _nearby_edges(self, index: int) -> Iterator[PoseGraphEdge]:
        """Yield loop closures to the submaps around the predicted pose."""
        radius = min(self._drift[index] + _IMAGE_RADIUS, _MAX_RADIUS)
        yaw_tolerance = min(_YAW_TOLERANCE * (1.0 + _YAW_GROWTH * self._drift[index]), _MAX_YAW_TOLERANCE)
        before = index - 1 if self.submaps[index].is_continuation else index
        while True:
            for other in self._candidates(index, before, radius):
                found = self._match_submap(index, other, radius, yaw_tolerance)
                if found is not None:
                    edge = self._make_edge(index, other, found, is_loop_closure=True)
                    yield edge
                    # The first edge fixes the pose of the submap; the others must agree with it.
                    self.poses.align([edge])
                    before, radius, yaw_tolerance = other, _EDGE_RADIUS, _YAW_TOLERANCE
                    break
            else:
                return

    def _candidates(self, index: int, before: int, radius: float) -> Iterator[int]:
        """Yield the submaps before number ``before`` that a submap may overlap, the latest first."""
        rotations, translations = self.poses.arrays()
        near = self._matchers.overlap_candidates(index, rotations / np.abs(rotations), translations, radius)
        for other in near[near < before][::-1].tolist():
            pose = self._pose(other).inverse() @ self._pose(index)
            if self._matchers.may_overlap(index, other, pose, radius):
                yield other

    def _match_submap(self, index: int, other: int, radius: float, yaw_tolerance: float) -> DotMatch | None:
        """Register a submap to another one near its predicted pose; None if they do not match."""
        matcher = self._matchers[other]
        expected = self._pose(other).inverse() @ self._pose(index)
        margin = _OVERLAP_MARGIN_CELLS * matcher.grid.cell + radius
        points = points_near(self._matchers[index].points, matcher.points, expected, margin)
        if len(points) == 0:
            return None
        # Relative to their centroid: far from the origin, a small rotation moves dots far.
        centroid = points.mean(axis=0)
        x, y = (float(value) for value in expected.transform([centroid])[0])
        expected_centroid = SE2(x, y, expected.yaw)
        tolerances = MatchTolerances(DOT_SIGMA, _SCALE_TOLERANCE, 0.0, self._settings.chance_alignments_max)
        found = matcher.match_near(points - centroid, expected_centroid, radius, yaw_tolerance, tolerances)
        return self._shared_dots(index, other, found, centroid)

    def _shared_dots(self, index: int, other: int, found: DotMatch | None, centroid: Floats) -> DotMatch | None:
        """Return all dots that two submaps share, given a match of some; None if they are too few."""
        if found is None:
            return None
        z = (self._matchers[index].points - centroid) @ (1.0, 1j)
        transformed = found.rotation * z + found.translation
        source, target = nearest_pairs(
            self._matchers[other].points,
            np.column_stack([transformed.real, transformed.imag]),
            _SHARED_GATE * DOT_SIGMA,
        )
        if len(source) < _MIN_SHARED_DOTS:
            return None
        return replace(_relative_to_origin(found, centroid), source=source, target=target)

    def _make_edge(self, index: int, other: int, found: DotMatch, *, is_loop_closure: bool) -> PoseGraphEdge:
        own_points, other_points = (
            self._matchers[index].points[found.source],
            self._matchers[other].points[found.target],
        )
        return PoseGraphEdge(other, index, _complex(other_points), _complex(own_points), is_loop_closure)

    def _global_edges(self, index: int) -> list[PoseGraphEdge]:
        """Search a submap among the dots of all earlier submaps; return the loop closures found."""
        others = self._earlier_dots(index)
        if others is None:
            return []
        matcher, owners = others
        points = self._matchers[index].points
        tolerances = MatchTolerances(
            DOT_SIGMA, _SCALE_TOLERANCE, 0.0, _GLOBAL_CHANCE_FACTOR * self._settings.chance_alignments_max
        )
        centroid = points.mean(axis=0)
        found = matcher.match_anywhere(points - centroid, tolerances)
        if found is None:
            return []
        found = _relative_to_origin(found, centroid)
        edges = []
        self.poses.rotations[index], self.poses.translations[index] = (
            found.rotation / abs(found.rotation),
            found.translation,
        )
        for other in np.unique(owners[found.target]):
            source = self._match_submap(index, int(other), _EDGE_RADIUS, _YAW_TOLERANCE)
            if source is not None:
                edges.append(self._make_edge(index, int(other), source, is_loop_closure=True))
        return edges

    def _earlier_dots(self, index: int) -> tuple[DotMatcher, Ints] | None:
        """Return the dots of earlier submaps and the submap of each; cached and rebuilt as the map grows."""
        until = index - 3 if len(self.submaps[0].images) else index
        if until < 1:
            return None
        if self._all_dots is None or until - self._all_dots[0] > 20 + until // 4:
            self._all_dots = None  # release it first: never two of them in memory
            parts, owners = [], []
            for k in range(until):
                z = self.poses.rotations[k] * (self._matchers.dots(k) @ (1.0, 1j)) + self.poses.translations[k]
                parts.append(np.column_stack([z.real, z.imag]))
                owners.append(np.full(len(z), k))
            self._all_dots = (until, DotMatcher(np.concatenate(parts)), np.concatenate(owners))
        return self._all_dots[1], self._all_dots[2]


def _relative_to_origin(found: DotMatch, centroid: Floats) -> DotMatch:
    """Return a match of dots relative to their centroid, shape (2,) [m], as one relative to the origin."""
    return replace(found, translation=found.translation - found.rotation * complex(*centroid))


def _complex(points: Floats) -> Complexes:
    return points[:, 0] + 1j * points[:, 1]
