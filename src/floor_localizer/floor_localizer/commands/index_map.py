"""``index_map``: converts dot maps of any size to the indexed binary format, out of core."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from floor_localizer.commands.options import add_worker_options, task_runner
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.files.array_file import DISK_FULL_ERRORS
from floor_localizer.files.map_building.index_build import IndexBuild


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, 1 for an invalid file or option, 130 when interrupted."""
    options = make_parser().parse_args(arguments)
    try:
        with task_runner(options.workers, options.scheduler) as runner:
            IndexBuild(options.maps, options.out, runner).run()
    except FloorLocalizerError as fault:
        print(f'index_map: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'index_map: {_describe_error(fault, options.out)}', file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print('\nindex_map: interrupted; run the same command again to resume', file=sys.stderr)
        return 130
    return 0


def _describe_error(fault: OSError, out: Path) -> str:
    if fault.errno in DISK_FULL_ERRORS:
        return (
            f'{out}: disk full ({fault.strerror}); free space and run the same command again, completed tasks are kept'
        )
    return f'{fault.filename or out}: {fault.strerror}; choose a writable place'


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='index_map',
        description='Convert dot maps of any size to the indexed binary format, which opens at once. An interrupted '
        'build is resumed by running the same command again.',
    )
    parser.add_argument(
        'maps',
        type=Path,
        nargs='+',
        metavar='MAP.csv',
        help='dot map; several are the levels (floors) of one map, named after the files',
    )
    parser.add_argument('--out', type=Path, required=True, metavar='OUT.dotmap', help='file to write')
    add_worker_options(parser)
    return parser


if __name__ == '__main__':
    sys.exit(main())
