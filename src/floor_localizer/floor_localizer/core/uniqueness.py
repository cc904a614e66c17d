"""Uniqueness of the places of a map: can the view at a place be confused with another place?

The map's own dots in a view are searched in the whole map like those of an image, but the search continues after the
first match to find the runner-up. A second search is for the view's mirror image: if the map contains it, a flipped
image or map would not be detected.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.constellation.acceptance import (
    AMBIGUITY_FRACTION,
    ScoredPose,
    SearchState,
    is_accepted,
    log_chance_alignments,
    new_search,
)
from floor_localizer.core.constellation.constellation_search import search_constellations
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.constellation.pair_search import search_pairs
from floor_localizer.core.dots import ViewDots, make_view, mirror_view
from floor_localizer.core.settings import LocalizerSettings
from shirube_core.settings import setting

# An ambiguous place shares a quarter of the view's constellations: some are among this number.
_EXTRA_LOOKUPS = 200
# Views with up to this many dots may have no constellation; the pair search finds them.
_FEW_DOTS = 14


@dataclass(frozen=True)
class ViewSettings:
    """The camera's view, for the inspection of a map."""

    view_size: float = setting(0.09, 'side of the square of floor in view', 'm', (0.01, 2.0))
    dot_sigma: float = setting(
        0.00015, 'standard deviation of a detected dot on the floor along each axis', 'm', (0.0, 0.01)
    )
    places_max: int = setting(2000, 'maximum number of inspected places', limits=(1, 10_000_000))


class PlaceKind(Enum):
    """Whether a robot can be located at a place."""

    UNIQUE = 'unique'
    TOO_FEW_DOTS = 'too few dots for a significant match'
    AMBIGUOUS = 'ambiguous with another place'
    MIRROR_AMBIGUOUS = 'ambiguous with the mirror image of another place'


@dataclass(frozen=True)
class Place:
    """One place of a map.

    Attributes:
        x: x of the view's centre [m].
        y: y of the view's centre [m].
        kind: whether a robot can be located there.
        dots: number of dots in view.
        expected_chance_alignments: expected number of chance alignments as good as the whole view.
        runner_up_fraction: fraction of the view's dots that match at the best other place.
        runner_up: x and y of that place [m]; None if nothing matches elsewhere.
    """

    x: float
    y: float
    kind: PlaceKind
    dots: int
    expected_chance_alignments: float
    runner_up_fraction: float
    runner_up: tuple[float, float] | None


def list_places(grid: DotGrid, settings: ViewSettings) -> Floats:
    """Return the places to inspect, shape (n, 2) [m]: a square lattice over the occupied floor, or some of the dots
    if no lattice point has dots in view.

    The views are adjacent, or have gaps between them on a large floor.
    """
    lower = np.array([grid.x0, grid.y0])
    upper = np.max(grid.points, axis=0).astype(np.float64)
    size = np.maximum(upper - lower, settings.view_size)
    pitch = max(settings.view_size, math.sqrt(float(np.prod(size)) / settings.places_max))
    counts = np.maximum((size / pitch).astype(np.int64), 1)
    axes = [lower[k] + (np.arange(counts[k]) + 0.5) * size[k] / counts[k] for k in range(2)]
    lattice = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    places = lattice[[len(_dots_in_view(grid, x, y, settings.view_size)) > 0 for x, y in lattice]]
    if len(places) > 0:
        return places
    # A coarse lattice may miss all of a floor that is mostly gaps.
    dots = np.linspace(0, len(grid.points) - 1, min(settings.places_max, len(grid.points))).astype(np.int64)
    return grid.points[dots].astype(np.float64)


def inspect_places(
    floor: IndexedMap, places: Floats, view_settings: ViewSettings, settings: LocalizerSettings
) -> Iterator[Place]:
    """Yield the uniqueness of each place, shape (n, 2) [m]."""
    for x, y in places:
        yield inspect_place(floor, (float(x), float(y)), view_settings, settings)


def inspect_place(
    floor: IndexedMap, centre: tuple[float, float], view_settings: ViewSettings, settings: LocalizerSettings
) -> Place:
    """Return how unique the view around a place, its centre x and y [m], is."""
    dots = _dots_in_view(floor.grid, *centre, view_settings.view_size)
    view = _make_view(dots - centre, floor.density, view_settings, settings)
    log_chance = _log_chance(floor, view)
    chance = math.exp(min(max(log_chance, -700.0), 700.0))
    search = _search(floor, view, settings)
    if log_chance >= search.log_threshold or not is_accepted(search, search.best):
        return Place(*centre, PlaceKind.TOO_FEW_DOTS, len(dots), chance, 0.0, None)
    if _match_fraction(search.runner_up, view) < AMBIGUITY_FRACTION:
        search = _continue_search(floor, view, search)
    kind, runner_up = PlaceKind.UNIQUE, _best_other_pose(search, centre, floor.grid.cell)
    if _match_fraction(runner_up, view) >= AMBIGUITY_FRACTION:
        kind = PlaceKind.AMBIGUOUS
    else:
        mirror_search = _search(floor, mirror_view(view), settings)
        if (
            is_accepted(mirror_search, mirror_search.best)
            and _match_fraction(mirror_search.best, view) >= AMBIGUITY_FRACTION
        ):
            kind, runner_up = PlaceKind.MIRROR_AMBIGUOUS, mirror_search.best
    where = (runner_up.b.real, runner_up.b.imag) if math.isfinite(runner_up.log_chance) else None
    return Place(*centre, kind, len(dots), chance, _match_fraction(runner_up, view), where)


def _dots_in_view(grid: DotGrid, x: float, y: float, side: float) -> Floats:
    """Return the dots in a square around a place, shape (n, 2) [m]."""
    half = 0.5 * side
    columns = np.clip([(x - half - grid.x0) // grid.cell, (x + half - grid.x0) // grid.cell], 0, grid.columns - 1)
    rows = np.clip([(y - half - grid.y0) // grid.cell, (y + half - grid.y0) // grid.cell], 0, grid.rows - 1)
    first, last = columns.astype(np.int64)
    parts = [
        grid.points[grid.starts[row * grid.columns + first] : grid.starts[row * grid.columns + last + 1]]
        for row in range(int(rows[0]), int(rows[1]) + 1)
    ]
    dots = np.concatenate(parts).astype(np.float64)
    return dots[(np.abs(dots - (x, y)) <= half).all(axis=1)]


def _make_view(points: Floats, density: float, view_settings: ViewSettings, settings: LocalizerSettings) -> ViewDots:
    sigma = math.hypot(view_settings.dot_sigma, settings.map_sigma)
    tilt_rate = settings.tilt_tolerance / view_settings.view_size
    return make_view(points, sigma, tilt_rate, settings.scale_tolerance, density)


def _search(floor: IndexedMap, view: ViewDots, settings: LocalizerSettings) -> SearchState:
    """Search for one significant place, as the localizer does."""
    search = new_search(
        len(view.z), float(len(floor.grid.points)), settings.chance_alignments_max, settings.match_rate_min
    )
    if not search_constellations(floor.grid, floor.index, view, search, _EXTRA_LOOKUPS) and len(view.z) <= _FEW_DOTS:
        search_pairs(floor.grid, floor.addresses, view, search, settings.pairs_max)
    return search


def _log_chance(floor: IndexedMap, view: ViewDots) -> float:
    """Return the logarithm of the expected number of chance alignments of a view with its own place.

    The residuals are the midpoint quantiles of the Rayleigh distribution.
    """
    n = len(view.z)
    residuals = view.sigma * np.sqrt(-2.0 * np.log1p(-(np.arange(n) + 0.5) / n))
    return log_chance_alignments(
        residuals, view.z, 0.5 * view.sigma, len(floor.grid.points), floor.density, view.scale_tolerance
    )


def _continue_search(floor: IndexedMap, view: ViewDots, found: SearchState) -> SearchState:
    """Look up more constellations after a place is found, to find an ambiguous place too."""
    search = found._replace(log_threshold=-math.inf)
    search_constellations(floor.grid, floor.index, view, search, search.counts[0] + _EXTRA_LOOKUPS)
    return search


def _best_other_pose(search: SearchState, centre: tuple[float, float], spacing: float) -> ScoredPose:
    """Return the better pose that is not the view's own; of two equal poses, either may be the best."""
    best = search.best
    off = max(abs(best.b.real - centre[0]), abs(best.b.imag - centre[1]))
    is_own = off < spacing and abs(best.a - 1.0) < 0.2
    return search.runner_up if is_own else best


def _match_fraction(pose: ScoredPose, view: ViewDots) -> float:
    return pose.matched / max(len(view.z), 1)
