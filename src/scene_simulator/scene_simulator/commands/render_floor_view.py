"""``render_floor_view``: write a picture of what the demo robot's camera sees."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2
import numpy as np

from scene_simulator.demo_scene import DemoScene

_ZOOM = 2


def main() -> int:
    """Run the command and return its exit code."""
    arguments = _parser().parse_args()
    scene = DemoScene()
    photo = scene.photograph(arguments.time, np.random.default_rng(scene.seed))
    image = cv2.resize(photo.image, None, fx=_ZOOM, fy=_ZOOM, interpolation=cv2.INTER_NEAREST)
    try:
        is_written = cv2.imwrite(str(arguments.picture), image)
    except cv2.error:
        is_written = False
    if not is_written:
        print(
            f'render_floor_view: {arguments.picture}: cannot be written; '
            'choose a writable place and a name that ends in .png',
            file=sys.stderr,
        )
        return 1
    print(f'{arguments.picture}: the view at {arguments.time} s of the demo drive')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='render_floor_view', description=__doc__)
    parser.add_argument('picture', type=Path, help='picture to write (.png)')
    parser.add_argument(
        '--time', type=float, default=3.6, help='time of the demo drive [s] (default: %(default)s)'
    )
    return parser


if __name__ == '__main__':
    sys.exit(main())
