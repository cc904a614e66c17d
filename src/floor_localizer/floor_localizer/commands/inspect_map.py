"""``inspect_map``: statistics of a dot map and the uniqueness of its places."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from tqdm import tqdm

from floor_localizer.commands.map_report import map_report, places_report
from floor_localizer.commands.options import run_command
from floor_localizer.core.arrays import Floats
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.uniqueness import Place, PlaceKind, ViewSettings, inspect_places, list_places
from floor_localizer.files.dot_map_file import load_dots_and_index, write_indexed_map
from shirube_core.command import add_settings, settings_from
from shirube_core.files import atomic_write

_LONG_SIDE, _MIN_SHORT_SIDE = 10.0, 3.0  # size of the plot [inch]
_MARGIN = np.array([1.5, 1.0])  # margin for scales and legend [inch]
_DOTS_PER_CELL = 60.0
_MARKS = {
    PlaceKind.TOO_FEW_DOTS: ('tab:orange', 'v'),
    PlaceKind.AMBIGUOUS: ('tab:red', 'o'),
    PlaceKind.MIRROR_AMBIGUOUS: ('tab:purple', 'D'),
}


def draw_map(file: BinaryIO, points: Floats, places: Sequence[Place], title: str) -> None:
    """Write a PNG of the dots, shape (N, 2) [m], and the inspected places."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - takes half a second, only the plot needs it

    size = np.maximum(np.ptp(points, axis=0), 1e-3)
    proportions = size / size.max()
    figure = Figure(figsize=np.maximum(_LONG_SIDE * proportions, _MIN_SHORT_SIDE) + _MARGIN, layout='constrained')
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]', title=title)
    _draw_density(figure, axes, points, size)
    for kind, (colour, mark) in _MARKS.items():
        xy = np.array([(place.x, place.y) for place in places if place.kind is kind]).reshape(-1, 2)
        if len(xy):
            axes.plot(*xy.T, mark, color=colour, fillstyle='none', label=f'{kind.value} ({len(xy)})')
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc='outside lower center')
    figure.savefig(file, format='png', dpi=100)


def _draw_density(figure: Any, axes: Any, points: Floats, size: Floats) -> None:
    cell = float(np.sqrt(np.prod(size) * _DOTS_PER_CELL / len(points)))
    counts = np.maximum((size / cell).astype(int), 1)
    dots, x_edges, y_edges = np.histogram2d(points[:, 0], points[:, 1], bins=[int(count) for count in counts])
    density = dots.T / np.prod(size / counts)
    shades = axes.pcolormesh(x_edges, y_edges, density, cmap='Greys', vmin=0.0, vmax=1.5 * density.max())
    figure.colorbar(shades, ax=axes, label='dots/m²', shrink=0.6)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file or option is invalid."""
    options = make_parser().parse_args(arguments)
    return run_command('inspect_map', lambda: inspect(options))


def inspect(options: argparse.Namespace) -> None:
    """Print the report and write the requested files."""
    view = settings_from(options, ViewSettings)
    dot_map, floor = load_dots_and_index(options.map)
    print(f'{"map":<16}{options.map}')
    print(map_report(dot_map, floor))
    if options.write is not None:
        write_indexed_map(options.write, dot_map, floor)
    points = list_places(floor.grid, view)
    inspected = inspect_places(floor, points, view, LocalizerSettings())
    places: list[Place] = list(tqdm(inspected, total=len(points), desc='places', unit='place', disable=None))
    print(places_report(places, view))
    if options.picture is not None:
        with atomic_write(options.picture) as file:
            draw_map(file, dot_map.points, places, options.map.name)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='inspect_map', description='Print statistics of a dot map and the uniqueness of its places.'
    )
    parser.add_argument('map', type=Path, help='dot map, CSV or .dotmap')
    parser.add_argument('--write', type=Path, metavar='OUT.dotmap', help='write the indexed binary format')
    parser.add_argument('--picture', type=Path, metavar='OUT.png', help='write a plot of density and places')
    add_settings(parser, ViewSettings)
    return parser


if __name__ == '__main__':
    sys.exit(main())
