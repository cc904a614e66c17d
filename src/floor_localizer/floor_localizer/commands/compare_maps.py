"""``compare_maps``: compare two dot maps of one floor."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.map_comparison import MapComparison, compare
from floor_localizer.files.dot_map_file import load_dot_map
from shirube_core.files import atomic_write


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file is invalid or the maps do not overlap."""
    options = make_parser().parse_args(arguments)
    try:
        compare_maps(options)
    except FloorLocalizerError as fault:
        print(f'compare_maps: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'compare_maps: {fault.filename}: {fault.strerror}; choose a writable place', file=sys.stderr)
        return 1
    return 0


def compare_maps(options: argparse.Namespace) -> None:
    """Print the comparison; plot it if ``--picture`` is given."""
    first, second = load_dot_map(options.first), load_dot_map(options.second)
    found = compare(first, second)
    print(comparison_report(found))
    if options.picture is not None:
        # Only the picture needs matplotlib, which takes half a second to import.
        from floor_localizer.comparison_picture import draw_comparison  # noqa: PLC0415

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
