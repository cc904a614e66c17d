"""Lay one set of dots on another: near an expected pose, or anywhere; taken only when it cannot be chance.

The searches are those of the localizer, and so is the test (see `acceptance`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from floor_localizer.core.constellation.constellation_search import search_constellations
from floor_localizer.core.constellation.dot_grid import build_dot_grid, pair_density
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.constellation.near_search import search_near
from floor_localizer.core.constellation.search_state import LOOKS_SAME, Search, is_accepted, new_search
from floor_localizer.core.constellation.view_dots import ViewDots, make_view
from floor_localizer.core.dot_map import DotMap
from shirube_geometry import PlanarPose

_LEAST_DOTS = 5
_NEAR_PAIRS = 40
_CELLS = 40_000
# Laying dots on others that they overlap only in part matches few of them; chance alone decides.
_SHARE = 0.02
# Dots nearer than this many standard deviations are the same.
_SAME_DOT = 4.0


@dataclass(frozen=True)
class Tolerances:
    """How far two sets of the same dots may differ.

    Attributes:
        sigma: standard deviation of a dot's place along each axis, in both together [m].
        scale: share by which one set may be larger.
        bend: shift of a dot over the square of its distance [1/m].
        chance: a match is taken when fewer as good are expected by chance.
    """

    sigma: float
    scale: float = 0.05
    bend: float = 0.0
    chance: float = 1e-4


@dataclass(frozen=True)
class Matched:
    """One set of dots laid on another.

    Attributes:
        turn: complex; a dot z of the laid set lies at ``turn * z + shift``, so its magnitude is the scale.
        shift: complex [m].
        laid: shape (k,), indices of the matched dots in the laid set.
        under: shape (k,), indices of the dots they lie on.
        log_chance: logarithm of how many matches as good are expected by chance.
    """

    turn: complex
    shift: complex
    laid: NDArray[np.int64]
    under: NDArray[np.int64]
    log_chance: float

    @property
    def pose(self) -> PlanarPose:
        """The laid set's frame in the other's, without the scale."""
        return PlanarPose(self.shift.real, self.shift.imag, math.atan2(self.turn.imag, self.turn.real))


class DotField:
    """Dots that others are laid on."""

    def __init__(self, points: NDArray[np.float64]) -> None:
        """Sort the dots, shape (n, 2) [m], n >= 1."""
        self.points = points
        self.grid, _ = build_dot_grid(points)
        self.density = pair_density(self.grid)
        self._floor: IndexedMap | None = None

    def match_near(
        self, points: NDArray[np.float64], expected: PlanarPose, radius: float, turn: float, by: Tolerances
    ) -> Matched | None:
        """Lay dots, shape (m, 2) [m], where they are expected.

        Args:
            points: the dots, about the origin of their frame.
            expected: of that frame.
            radius: how far it may be from there [m].
            turn: how far it may be turned from there [rad].
            by: what counts as the same dot.
        """
        if len(points) < _LEAST_DOTS or len(self.points) < _LEAST_DOTS:
            return None
        view = make_view(_contiguous(points), by.sigma, by.bend, by.scale, self.density)
        around = (
            self.density * math.pi * (radius + 2.0 * self.grid.cell) ** 2 * min(turn / math.pi + 0.1, 1.0)
        )
        search = new_search(len(points), max(min(around, float(len(self.points))), 1.0), by.chance, _SHARE)
        pose = np.array([expected.x, expected.y, expected.yaw])
        found = search_near(self.grid, view, search, pose, radius, turn, _NEAR_PAIRS)
        return self._matched(view, search) if found else None

    def match_anywhere(self, points: NDArray[np.float64], by: Tolerances) -> Matched | None:
        """Lay dots, shape (m, 2) [m], wherever they fit; None where they fit nowhere or at two places alike."""
        if len(points) < _LEAST_DOTS or len(self.points) < _LEAST_DOTS:
            return None
        if self._floor is None:
            self._floor = index_map(DotMap(self.points, np.full(len(self.points), np.nan)))
        view = make_view(_contiguous(points), by.sigma, by.bend, by.scale, self.density)
        search = new_search(len(points), float(len(self.points)), by.chance, _SHARE)
        if not search_constellations(self._floor.grid, self._floor.index, view, search, _CELLS):
            return None
        if is_accepted(search, search.rival) and search.rival[5] >= LOOKS_SAME * search.best[5]:
            return None
        return self._matched(view, search)

    def _matched(self, view: ViewDots, search: Search) -> Matched:
        """Return the best pose with its matches, each dot once."""
        best = search.best
        a, b = complex(best[1], best[2]), complex(best[3], best[4])
        places = a * view.z + b
        xy = np.column_stack([places.real, places.imag])
        laid, under = nearest_pairs(self.points, xy, _SAME_DOT * view.sigma)
        return Matched(a, b, laid, under, float(best[0]))


def _contiguous(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points in rows: the compiled search knows one layout."""
    return np.ascontiguousarray(points, dtype=np.float64)


def nearest_pairs(
    dots: NDArray[np.float64], places: NDArray[np.float64], reach: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return pairs of places and dots: each place's nearest dot within reach, each dot once.

    Args:
        dots: shape (n, 2) [m].
        places: shape (m, 2) [m].
        reach: a pair is no farther apart than this [m].

    Returns:
        indices of the places, rising, and of their dots.
    """
    found = cKDTree(dots).query(places, distance_upper_bound=reach)
    distance, nearest = np.asarray(found[0]), np.asarray(found[1], dtype=np.int64)
    near = np.flatnonzero(np.isfinite(distance))
    order = near[np.argsort(distance[near], kind='stable')]
    _, first = np.unique(nearest[order], return_index=True)
    kept = np.sort(order[first])
    return kept, nearest[kept]
