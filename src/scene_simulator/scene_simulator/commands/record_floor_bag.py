"""``record_floor_bag``: render the demo drive and write it as a bag; the same seed gives the same bag."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from tqdm import tqdm

from scene_simulator.demo_scene import DemoScene
from scene_simulator.errors import SceneError
from scene_simulator.floor_bag import image_count, record_drive
from shirube_bags.errors import BagError


def main() -> int:
    """Run the command and return its exit code."""
    arguments = _parser().parse_args()
    try:
        images = record_drive(DemoScene(arguments.seed), arguments.bag, arguments.seconds)
        count = image_count(arguments.seconds)
        for _ in tqdm(images, 'rendering', count, unit='image', mininterval=1.0, delay=1.0):
            pass
    except (BagError, SceneError) as error:
        print(f'record_floor_bag: {error}', file=sys.stderr)
        return 1
    print(f'{arguments.bag}: {arguments.seconds} s of the demo drive')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='record_floor_bag', description=__doc__)
    parser.add_argument('bag', type=Path, help='folder of the bag to write')
    parser.add_argument(
        '--seed',
        type=int,
        default=DemoScene.seed,
        help='seed of dirt, noise and suspension (default: %(default)s)',
    )
    parser.add_argument('--seconds', type=float, default=60.0, help='length [s] (default: %(default)s)')
    return parser


if __name__ == '__main__':
    sys.exit(main())
