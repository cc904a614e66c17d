"""Statistics of a dot map: number, density and size of the dots, and size of the index."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from floor_localizer.core.arrays import Floats
from floor_localizer.core.constellation.dot_grid import typical_spacing
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.dots import DotMap
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings


@dataclass(frozen=True)
class MapStatistics:
    """Statistics of a map.

    Attributes:
        dots: number of dots.
        lower: shape (2,), lower left corner of the dots' bounding box [m].
        upper: shape (2,), upper right corner [m].
        area: area of the occupied floor, without gaps between rooms [m^2].
        density: density of dots in that area [1/m^2].
        diameters: shape (3,), smallest, median and largest known diameter [m]; None if none is known.
        known_diameter_fraction: fraction of the dots with a known diameter.
        constellations: number of constellations in the index.
        bytes_per_dot: size of dots and index, in memory and in the binary format, per dot [bytes].
    """

    dots: int
    lower: Floats
    upper: Floats
    area: float
    density: float
    diameters: Floats | None
    known_diameter_fraction: float
    constellations: int
    bytes_per_dot: float


def compute_map_statistics(dot_map: DotMap, floor: IndexedMap) -> MapStatistics:
    """Return the statistics of a map, given with its index."""
    density = 1.0 / typical_spacing(dot_map.points) ** 2
    known = dot_map.diameters[np.isfinite(dot_map.diameters)]
    arrays = (
        *(floor.grid.points, floor.grid.starts, floor.addresses.bits),
        *(floor.index.entries, floor.index.starts),
    )
    return MapStatistics(
        dots=len(dot_map),
        lower=dot_map.points.min(axis=0),
        upper=dot_map.points.max(axis=0),
        area=len(dot_map) / density,
        density=density,
        diameters=np.percentile(known, [0.0, 50.0, 100.0]) if len(known) else None,
        known_diameter_fraction=len(known) / len(dot_map),
        constellations=len(floor.index.entries),
        bytes_per_dot=sum(array.nbytes for array in arrays) / len(dot_map),
    )


_MAX_LISTED = 10


def map_report(statistics: MapStatistics) -> str:
    """Return the statistics of a map as lines of text."""
    width, height = statistics.upper - statistics.lower
    diameters = 'unknown'
    if statistics.diameters is not None:
        smallest, median, largest = 1e3 * statistics.diameters
        diameters = f'{smallest:.2f} to {largest:.2f} mm, median {median:.2f} mm'
        diameters += f', known for {statistics.known_diameter_fraction:.0%} of the dots'
    x0, y0 = statistics.lower
    x1, y1 = statistics.upper
    rows = (
        ('dots', f'{statistics.dots}'),
        ('extent', f'{width:.3f} x {height:.3f} m: x {x0:.3f} to {x1:.3f}, y {y0:.3f} to {y1:.3f}'),
        ('area with dots', f'{statistics.area:.3f} m²'),
        ('density', f'{statistics.density:.0f} dots/m², {1e3 * statistics.density**-0.5:.1f} mm apart'),
        ('diameters', diameters),
        (
            'constellations',
            f'{statistics.constellations}, {statistics.constellations / statistics.dots:.1f} per dot',
        ),
        ('size', f'{statistics.bytes_per_dot:.0f} bytes per dot'),
    )
    return '\n'.join(f'{name:<16}{value}' for name, value in rows)


def places_report(places: Sequence[Place], view: ViewSettings) -> str:
    """Return the uniqueness of the places as lines of text, with the first ten of each kind that is not unique."""
    counts = Counter(place.kind for place in places)
    unique = counts[PlaceKind.UNIQUE] / len(places)
    first = (
        f'{"unique places":<16}{unique:.1%} of {len(places)} views of {1e3 * view.view_size:.0f} mm, '
        f'{min(place.dots for place in places)} to {max(place.dots for place in places)} dots each'
    )
    lines = [first]
    for kind in PlaceKind:
        if kind is PlaceKind.UNIQUE or not counts[kind]:
            continue
        lines.append(f'{counts[kind]} places: {kind.value}')
        of_kind = [place for place in places if place.kind is kind]
        lines += [f'    {_line(place)}' for place in of_kind[:_MAX_LISTED]]
        if len(of_kind) > _MAX_LISTED:
            lines.append(f'    and {len(of_kind) - _MAX_LISTED} more')
    return '\n'.join(lines)


def _line(place: Place) -> str:
    number = f'{place.dots} dot' if place.dots == 1 else f'{place.dots} dots'
    text = f'({place.x:.3f}, {place.y:.3f}) m, {number}'
    if place.kind is PlaceKind.TOO_FEW_DOTS:
        if place.expected_chance_alignments > 1.0:
            return f'{text}, expected chance alignments above 1'
        return f'{text}, expected chance alignments {place.expected_chance_alignments:.1g}'
    if place.runner_up is None:
        return text
    return f'{text}, {place.runner_up_fraction:.0%} match at ({place.runner_up[0]:.3f}, {place.runner_up[1]:.3f}) m'
