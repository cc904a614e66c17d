"""``record_room_bag``: render a drive through a furnished room as a bag; the same seed gives the same bag."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from scene_simulator.errors import SceneError
from scene_simulator.room_bag import instant_count, record_room_drive
from scene_simulator.room_drive import RoomDrive
from shirube_bags.errors import BagError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when an option is bad or the bag cannot be written."""
    options = _parser().parse_args(arguments)
    try:
        instants = record_room_drive(RoomDrive(options.seed), options.bag, options.seconds)
        total = instant_count(options.seconds)
        for _ in tqdm(instants, 'rendering', total, unit='instant', mininterval=1.0, delay=1.0):
            pass
    except (BagError, SceneError) as error:
        print(f'record_room_bag: {error}', file=sys.stderr)
        return 1
    print(f'{options.bag}: {options.seconds} s of a drive through a room')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='record_room_bag', description=__doc__)
    parser.add_argument('bag', type=Path, help='folder of the bag to write')
    parser.add_argument(
        '--seed', type=int, default=RoomDrive.seed, help='seed of furniture and noise (default: %(default)s)'
    )
    parser.add_argument('--seconds', type=float, default=28.0, help='length [s] (default: %(default)s)')
    return parser


if __name__ == '__main__':
    sys.exit(main())
