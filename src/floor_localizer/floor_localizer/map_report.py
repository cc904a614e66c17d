"""The report of `inspect_map`: statistics of a map and the uniqueness of its places."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from floor_localizer.core.map_inspection import MapStatistics
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings

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
