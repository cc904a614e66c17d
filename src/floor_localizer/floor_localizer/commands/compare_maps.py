"""``compare_maps``: compare two dot maps of one floor."""

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from floor_localizer.commands.options import run_command
from floor_localizer.core.dots import DotMap
from floor_localizer.core.survey.map_comparison import MapComparison, compare
from floor_localizer.files.dot_map_file import load_dot_map
from shirube_core.files import atomic_write

_MAX_ARROWS = 1500
_MAX_LENGTH = 1.5  # maximum length of an arrow [lengths of the 95th percentile]
_ARROW_LENGTH = 0.04  # length of the arrow of the 95th percentile, as a fraction of the plot


def draw_comparison(file: BinaryIO, first: DotMap, second: DotMap, found: MapComparison) -> None:
    """Write a PNG: magnified arrows from the first map's dots to the second's, and dots that are in only one map."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - takes half a second, only the plot needs it

    figure = Figure(figsize=(10.0, 9.0), layout='constrained')
    axes = figure.add_subplot(aspect='equal', xlabel='x [m]', ylabel='y [m]')
    places = first.points[found.pairs[:, 0]]
    chosen = np.linspace(0, len(places) - 1, min(len(places), _MAX_ARROWS)).astype(int)
    lengths = np.hypot(*found.residuals.T)
    typical = max(float(np.percentile(lengths, 95.0)), 1e-7)
    size = float(np.ptp(first.points, axis=0).max())
    # Clipped: the arrow of two chips detected as one would cross the whole plot.
    shown = found.residuals * np.minimum(1.0, _MAX_LENGTH * typical / np.maximum(lengths, 1e-12))[:, None]
    arrows = axes.quiver(
        *places[chosen].T, *shown[chosen].T, 1e3 * lengths[chosen], angles='xy', scale_units='xy',
        scale=typical / (_ARROW_LENGTH * size), cmap='viridis', width=0.0015, clim=(0.0, 1e3 * _MAX_LENGTH * typical),
    )  # fmt: skip
    figure.colorbar(arrows, ax=axes, extend='max', label='distance between the maps [mm]', shrink=0.7)
    moved = found.T_first_second.transform(second.points)
    for points, colour, mark, name in (
        (first.points[found.missing], 'tab:red', 'o', f'only in the first ({len(found.missing)})'),
        (moved[found.extra], 'tab:blue', 's', f'only in the second ({len(found.extra)})'),
    ):
        if len(points):
            axes.plot(*points.T, mark, color=colour, fillstyle='none', markersize=4, label=name)
    axes.set_title(f'arrows magnified {_ARROW_LENGTH * size / typical:.0f} times')
    if axes.get_legend_handles_labels()[0]:
        figure.legend(loc='outside lower center', ncols=2)
    figure.savefig(file, format='png', dpi=100)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file is invalid or the maps do not overlap."""
    options = make_parser().parse_args(arguments)
    return run_command('compare_maps', lambda: compare_maps(options))


def compare_maps(options: argparse.Namespace) -> None:
    """Print the comparison; plot it if ``--picture`` is given."""
    first, second = load_dot_map(options.first), load_dot_map(options.second)
    found = compare(first, second)
    print(comparison_report(found))
    if options.picture is not None:
        with atomic_write(options.picture) as file:
            draw_comparison(file, first, second, found)


def comparison_report(found: MapComparison) -> str:
    """Return the statistics of a comparison as text."""
    pose = found.T_first_second
    lengths = 1e3 * np.hypot(*found.residuals.T)
    apart = f'{1e3 * found.rms:.4f} mm rms, {np.percentile(lengths, 95.0):.4f} mm for 95 %'
    apart += f', {1e3 * found.largest:.4f} mm max, after this motion'
    rows = (
        ('common dots', f'{len(found.pairs)}'),
        ('motion', f'x {pose.x:.6f} m, y {pose.y:.6f} m, yaw {math.degrees(pose.yaw):.4f}°'),
        ('apart', apart),
        ('scale', f'the second is larger by {100.0 * (found.scale - 1.0):+.4f} %'),
        ('missing', f'{len(found.missing)} dots of the first are not in the second'),
        ('extra', f'{len(found.extra)} dots of the second are not in the first'),
        ('outside', f'{found.outside} dots are outside the area of the other map'),
    )  # fmt: skip
    return '\n'.join(f'{name:<14}{text}' for name, text in rows)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='compare_maps',
        description='Register one dot map to another, independent of their origins, and compare them.',
    )
    parser.add_argument('first', type=Path, help='dot map, CSV or .dotmap')
    parser.add_argument('second', type=Path, help='dot map, CSV or .dotmap')
    parser.add_argument('--picture', type=Path, metavar='OUT.png', help='plot the differences to this file')
    return parser


if __name__ == '__main__':
    sys.exit(main())
