"""``index_map``: converts dot maps of any size to the indexed binary format, out of core."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from floor_localizer.commands.options import add_worker_options, run_resumable, task_runner
from floor_localizer.files.map_building.index_build import IndexBuild


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, 1 for an invalid file or option, 130 when interrupted."""
    options = make_parser().parse_args(arguments)
    return run_resumable('index_map', lambda: index_maps(options), options.out)


def index_maps(options: argparse.Namespace) -> None:
    """Build the map."""
    with task_runner(options.workers, options.scheduler) as runner:
        IndexBuild(options.maps, options.out, runner).run()


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='index_map',
        description='Convert dot maps of any size to the indexed binary format, which opens at once. An interrupted '
        'build is resumed by running the same command again.',
    )
    about = 'dot map; several are the levels (floors) of one map, named after the files'
    parser.add_argument('maps', type=Path, nargs='+', metavar='MAP.csv', help=about)
    parser.add_argument('--out', type=Path, required=True, metavar='OUT.dotmap', help='file to write')
    add_worker_options(parser)
    return parser


if __name__ == '__main__':
    sys.exit(main())
