"""``print_mat``: a random-dot mat as a PDF at true scale, and its dot map."""

import argparse
import secrets
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from floor_localizer.commands.map_report import places_report
from floor_localizer.commands.options import run_command
from floor_localizer.core.mat.page_layout import (
    PAPERS,
    ROLL,
    MatSettings,
    PageSettings,
    divide_into_pages,
    generate_unique_mat,
    mat_size_of_page,
)
from floor_localizer.core.uniqueness import ViewSettings
from floor_localizer.files.dot_map_file import save_csv
from shirube_core.command import add_settings, settings_from
from shirube_core.files import atomic_write

_SEEDS = 10**6


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when an option is invalid or a file cannot be written."""
    options = make_parser().parse_args(arguments)
    return run_command('print_mat', lambda: print_mat(options), options.out)


def print_mat(options: argparse.Namespace) -> None:
    """Write the PDF and the dot map."""
    # Only this command draws PDFs; matplotlib takes half a second to import.
    from floor_localizer.commands.mat_drawing import draw_mat  # noqa: PLC0415

    page_settings, view = settings_from(options, PageSettings), settings_from(options, ViewSettings)
    mat_settings = settings_from(options, MatSettings)
    width, height = mat_size_of_page(options.paper, page_settings)
    mat_settings = replace(mat_settings, width=mat_settings.width or width, height=mat_settings.height or height)
    layout = divide_into_pages(mat_settings, options.paper, page_settings)
    seed = secrets.randbelow(_SEEDS) if options.seed is None else options.seed
    mat, places = generate_unique_mat(mat_settings, seed, view)
    with atomic_write(options.out) as file:
        draw_mat(file, mat, layout)
    map_path = options.out.with_suffix('.csv')
    save_csv(map_path, mat.dot_map)
    print(f'{options.out}: {len(mat.points)} dots on {len(layout.pages)} x {options.paper}, seed {seed}')
    print(places_report(places, view))
    print(f'{map_path}: the dot map, origin in the lower left corner; print at 100 % and measure the scale bar')


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='print_mat',
        description='Make a mat of random dots: a PDF to print at true scale, and its dot map in the same folder.',
    )
    add = parser.add_argument
    add('--out', type=Path, default=Path('mat.pdf'), metavar='PDF', help='default: %(default)s')
    add('--paper', choices=[*PAPERS, ROLL], default='A4', help='default: %(default)s')
    add('--seed', type=int, help='seed of the dots, to print the same mat again (default: a new one each time)')
    for kind in (MatSettings, PageSettings, ViewSettings):
        add_settings(parser, kind)
    return parser


if __name__ == '__main__':
    sys.exit(main())
