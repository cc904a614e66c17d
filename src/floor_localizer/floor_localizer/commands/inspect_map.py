"""``inspect_map``: statistics of a dot map and the uniqueness of its places."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from floor_localizer.commands.setting_options import add_settings, settings_from
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.map_inspection import compute_map_statistics
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.uniqueness import Place, ViewSettings, inspect_places, list_places
from floor_localizer.files.dot_map_file import load_dots_and_index, write_indexed_map
from floor_localizer.map_report import map_report, places_report
from shirube_core.files import atomic_write
from shirube_core.settings import SettingsError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 for an invalid file or option."""
    options = make_parser().parse_args(arguments)
    try:
        inspect(options)
    except (FloorLocalizerError, SettingsError) as fault:
        print(f'inspect_map: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'inspect_map: {fault.filename}: {fault.strerror}; choose a writable place', file=sys.stderr)
        return 1
    return 0


def inspect(options: argparse.Namespace) -> None:
    """Print the report and write the requested files."""
    view = settings_from(options, ViewSettings)
    dot_map, floor = load_dots_and_index(options.map)
    print(f'{"map":<16}{options.map}')
    print(map_report(compute_map_statistics(dot_map, floor)))
    if options.write is not None:
        write_indexed_map(options.write, dot_map, floor)
    points = list_places(floor.grid, view)
    places: list[Place] = list(
        tqdm(
            inspect_places(floor, points, view, LocalizerSettings()),
            total=len(points),
            desc='places',
            unit='place',
            disable=None,
        )
    )
    print(places_report(places, view))
    if options.picture is not None:
        # Imported here, as it takes half a second and only the plot needs it.
        from floor_localizer.map_picture import draw_map  # noqa: PLC0415

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
