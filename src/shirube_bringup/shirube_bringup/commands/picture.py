"""``picture``: make the moving picture of a finished mission."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from shirube_bringup.record import MissionTraces
from shirube_bringup.report.moving_picture import write_moving_picture


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 after an error."""
    parser = argparse.ArgumentParser(prog='picture', description=__doc__)
    parser.add_argument('folder', type=Path, help='folder of the mission, with its traces.json')
    parser.add_argument('picture', type=Path, help='file to write, .gif or .webp')
    options = parser.parse_args(arguments)
    source, target = options.folder / 'traces.json', options.picture
    if target.suffix not in ('.gif', '.webp'):
        parser.error(f'{target}: choose a name that ends with .gif or .webp')
    try:
        write_moving_picture(target, MissionTraces.from_json(source.read_text()))
    except (LookupError, TypeError, ValueError):
        print(f'picture: {source}: not the traces of a mission; drive it again with `room`', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'picture: {fault.filename}: {fault.strerror}; choose another path', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
