"""Register one set of dots to another, near an expected pose or anywhere; chance matches are rejected.

The searches and the acceptance test are those of the localizer (see `acceptance`).
"""

import math
from dataclasses import astuple, dataclass

import numpy as np
from scipy.spatial import cKDTree

from floor_localizer.core.arrays import Floats, Ints
from floor_localizer.core.constellation.acceptance import SearchState, new_search
from floor_localizer.core.constellation.constellation_search import search_constellations
from floor_localizer.core.constellation.dot_grid import build_dot_grid, pair_density
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.constellation.pair_search import search_near
from floor_localizer.core.dots import DotMap, ViewDots, make_view
from shirube_core.geometry import SE2

_MIN_DOTS = 5
_MAX_NEAR_PAIRS = 40
_MAX_CELLS = 40_000
# Two sets may overlap only in part, so few dots match; the test against chance decides.
_MIN_MATCH_FRACTION = 0.02
# Two dots within this many standard deviations match.
_MATCH_GATE = 4.0


@dataclass(frozen=True)
class MatchTolerances:
    """How far two sets of the same dots may differ.

    Attributes:
        sigma: standard deviation of the distance between matched dots along each axis [m].
        scale: largest relative difference in scale.
        tilt_distortion: largest shift of a dot, divided by its squared distance from the origin [1/m].
        chance_alignments_max: largest expected number of equally good matches by chance.
    """

    sigma: float
    scale: float = 0.05
    tilt_distortion: float = 0.0
    chance_alignments_max: float = 1e-4


@dataclass(frozen=True)
class DotMatch:
    """Registration of a source set of dots to a target set.

    Attributes:
        rotation: complex rotation and scale; a source dot z maps to ``rotation * z + translation``.
        translation: complex translation [m].
        source: indices of the matched dots in the source set, shape (k,).
        target: indices of the matched dots in the target set, shape (k,).
        log_chance_alignments: logarithm of the expected number of equally good matches by chance.
    """

    rotation: complex
    translation: complex
    source: Ints
    target: Ints
    log_chance_alignments: float

    @property
    def pose(self) -> SE2:
        """Pose of the source frame in the target frame, without the scale."""
        return SE2(self.translation.real, self.translation.imag, math.atan2(self.rotation.imag, self.rotation.real))


class DotMatcher:
    """Matches sets of dots against a target set."""

    def __init__(self, points: Floats) -> None:
        """Build the grid of the target dots, shape (n, 2) [m], n >= 1."""
        self.points = points
        self.grid, _ = build_dot_grid(points)
        self.density = pair_density(self.grid)
        self._index: IndexedMap | None = None

    def match_near(
        self, points: Floats, expected: SE2, radius: float, yaw_tolerance: float, tolerances: MatchTolerances
    ) -> DotMatch | None:
        """Match dots near an expected pose; return None if there is no match.

        Args:
            points: source dots around the origin of their frame, shape (m, 2) [m].
            expected: expected pose of the source frame in the target frame.
            radius: search radius around the expected position [m].
            yaw_tolerance: largest difference from the expected yaw [rad].
            tolerances: tolerances of the match.
        """
        if len(points) < _MIN_DOTS or len(self.points) < _MIN_DOTS:
            return None
        area = math.pi * (radius + 2.0 * self.grid.cell) ** 2
        expected_dots = self.density * area * min(yaw_tolerance / math.pi + 0.1, 1.0)
        view, search = self._begin_search(points, expected_dots, tolerances)
        pose = np.array([expected.x, expected.y, expected.yaw])
        found = search_near(self.grid, view, search, pose, radius, yaw_tolerance, _MAX_NEAR_PAIRS)
        return self._matched(view, search) if found else None

    def match_anywhere(self, points: Floats, tolerances: MatchTolerances) -> DotMatch | None:
        """Match dots, shape (m, 2) [m], at any pose; return None if there is no match or it is ambiguous."""
        if len(points) < _MIN_DOTS or len(self.points) < _MIN_DOTS:
            return None
        if self._index is None:
            self._index = index_map(DotMap(self.points, np.full(len(self.points), np.nan)))
        view, search = self._begin_search(points, math.inf, tolerances)
        if not search_constellations(self._index.grid, self._index.index, view, search, _MAX_CELLS):
            return None
        return self._matched(view, search) if len(search.plausible_poses()) == 1 else None

    def _begin_search(
        self, points: Floats, expected_dots: float, tolerances: MatchTolerances
    ) -> tuple[ViewDots, SearchState]:
        points = np.ascontiguousarray(points, dtype=np.float64)  # as the compiled kernels expect
        sigma, scale, tilt_distortion, chance = astuple(tolerances)
        candidates = max(min(expected_dots, float(len(self.points))), 1.0)
        search = new_search(len(points), candidates, chance, _MIN_MATCH_FRACTION)
        return make_view(points, sigma, tilt_distortion, scale, self.density), search

    def _matched(self, view: ViewDots, search: SearchState) -> DotMatch:
        """Return the best pose with its one-to-one matches."""
        log_chance, a, b, _ = search.best
        points = a * view.z + b
        xy = np.column_stack([points.real, points.imag])
        source, target = nearest_pairs(self.points, xy, _MATCH_GATE * view.sigma)
        return DotMatch(a, b, source, target, log_chance)


def nearest_pairs(dots: Floats, points: Floats, max_distance: float) -> tuple[Ints, Ints]:
    """Return one-to-one pairs of points, shape (m, 2), and their nearest dots, shape (n, 2), within a distance [m].

    Returns:
        indices of the matched points, ascending, and of their dots.
    """
    found = cKDTree(dots).query(points, distance_upper_bound=max_distance)
    distance, nearest = np.asarray(found[0]), np.asarray(found[1], dtype=np.int64)
    near = np.flatnonzero(np.isfinite(distance))
    order = near[np.argsort(distance[near], kind='stable')]
    _, first = np.unique(nearest[order], return_index=True)
    kept = np.sort(order[first])
    return kept, nearest[kept]
