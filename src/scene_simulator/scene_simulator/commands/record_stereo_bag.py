"""``record_stereo_bag``: render a drive in a corridor with meters as a bag; the same seed gives the same bag."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from scene_simulator.corridor_generator import CorridorDesign
from scene_simulator.corridor_recordings import RUNS, SECONDS, make_corridor_drive
from scene_simulator.errors import SceneError
from scene_simulator.stereo_bag import record_stereo_drive
from scene_simulator.stereo_rig import StereoRig, raw_rig
from shirube_bags.errors import BagError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when an option is bad or the bag cannot be written."""
    options = _parser().parse_args(arguments)
    try:
        drive = make_corridor_drive(
            options.run, CorridorDesign(options.seed), raw_rig() if options.raw else StereoRig()
        )
        pairs = record_stereo_drive(drive, options.bag, options.seconds)
        total = drive.frame_count(options.seconds)
        for _ in tqdm(pairs, 'rendering', total, unit='pair', mininterval=1.0, delay=1.0):
            pass
    except (BagError, SceneError) as error:
        print(f'record_stereo_bag: {error}', file=sys.stderr)
        return 1
    print(f'{options.bag}: {options.seconds} s of the run {options.run!r}')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='record_stereo_bag', description=__doc__)
    parser.add_argument('bag', type=Path, help='folder of the bag to write')
    parser.add_argument('run', choices=RUNS, help='which drive')
    parser.add_argument('--seed', type=int, default=0, help='seed of the corridor (default: %(default)s)')
    parser.add_argument('--raw', action='store_true', help='raw (distorted) images instead of rectified ones')
    parser.add_argument('--seconds', type=float, default=SECONDS, help='length [s] (default: %(default)s)')
    return parser


if __name__ == '__main__':
    sys.exit(main())
