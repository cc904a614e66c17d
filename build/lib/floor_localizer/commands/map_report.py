"""The report of `inspect_map`: statistics of a map and the uniqueness of its places."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from floor_localizer.core.constellation.dot_grid import typical_spacing
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.dots import DotMap
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings

_MAX_LISTED = 10


def map_report(dot_map: DotMap, floor: IndexedMap) -> str:
    """Return the statistics of a map, given with its index, as lines of text."""
    dots, (x0, y0), (x1, y1) = len(dot_map), dot_map.points.min(axis=0), dot_map.points.max(axis=0)
    # Density of the occupied floor, without gaps between rooms.
    density = 1.0 / typical_spacing(dot_map.points) ** 2
    known, diameters = dot_map.diameters[np.isfinite(dot_map.diameters)], 'unknown'
    if len(known):
        smallest, median, largest = 1e3 * np.percentile(known, [0.0, 50.0, 100.0])
        diameters = f'{smallest:.2f} to {largest:.2f} mm, median {median:.2f} mm'
        diameters += f', known for {len(known) / dots:.0%} of the dots'
    keys = floor.index.entries
    arrays = floor.grid.points, floor.grid.starts, floor.addresses.bits, keys, floor.index.starts
    rows = (
        ('dots', f'{dots}'),
        ('extent', f'{x1 - x0:.3f} x {y1 - y0:.3f} m: x {x0:.3f} to {x1:.3f}, y {y0:.3f} to {y1:.3f}'),
        ('area with dots', f'{dots / density:.3f} m²'),
        ('density', f'{density:.0f} dots/m², {1e3 * density**-0.5:.1f} mm apart'),
        ('diameters', diameters),
        ('constellations', f'{len(keys)}, {len(keys) / dots:.1f} per dot'),
        ('size', f'{sum(array.nbytes for array in arrays) / dots:.0f} bytes per dot'),
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
