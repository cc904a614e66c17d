"""``record_lamp_bag``: render the paper's run under its lamps and write it as a bag; the same seed gives the same bag.

What the lamps send comes from waveform files, such as ``vlc_beacon encode --csv`` writes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from scene_simulator.camera_clock import CameraClock
from scene_simulator.ceiling_camera import CeilingCamera
from scene_simulator.ceiling_room import PAPER_LAMPS
from scene_simulator.errors import SceneError
from scene_simulator.lamp_bag import record_lamp_drive, write_beacons
from scene_simulator.lamp_drive import LampDrive
from scene_simulator.lamp_shape import Disc, LedGrid
from scene_simulator.paper_run import paper_run
from scene_simulator.shutter import Shutter
from shirube_bags.errors import BagError
from shirube_core.geometry import PinholeCamera
from shirube_core.waveform import LightWaveformError, Waveform, waveform_from_csv

GLOBAL = CeilingCamera(PinholeCamera(640, 512, 318.2, 318.2, 319.5, 255.5))
"""The paper's camera at half its resolution: large enough to read the lamps, and a third of the bag's size."""

ROLLING = CeilingCamera(shutter=Shutter(exposure=60e-6, row_time=18.9e-6))
"""A telephone's shutter behind the paper's optics at full resolution: a lamp must cover 16 rows."""

REST = 5.0
"""Two IDs and two commands of lamp A have then been played when the robot begins to turn there [s]."""

CLOCK_RATIO, JITTER = 1.00005, 5e-5
"""Clock rate of the camera relative to the lamps (50 ppm); the jitter of the stamps [s]."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a waveform or an option is bad or the bag cannot be written."""
    options = _parser().parse_args(arguments)
    try:
        drive, ids = make_drive(options)
        images = record_lamp_drive(drive, options.bag, options.seconds)
        total = drive.frame_count(options.seconds)
        for _ in tqdm(images, 'rendering', total, unit='image', mininterval=1.0, delay=1.0):
            pass
        write_beacons(list(zip(ids, PAPER_LAMPS, strict=True)), LedGrid.radius, options.bag / 'beacons.yaml')
    except (BagError, SceneError) as error:
        print(f'record_lamp_bag: {error}', file=sys.stderr)
        return 1
    print(f"{options.bag}: {options.seconds} s of the paper's run")
    return 0


def make_drive(options: argparse.Namespace) -> tuple[LampDrive, list[int]]:
    """Return the drive that the options ask for, and the IDs of its lamps.

    Raises:
        SceneError: a file that is no waveform, an ID that is no number or there twice, not four lamps, a bad seed.
    """
    ids, waveforms = [], []
    for text in options.lamp:
        name, _, path = text.partition('=')
        if not name.isdecimal() or int(name) in ids or not path:
            raise SceneError(f'{text}: give each lamp as ID=FILE.csv, with a unique ID')
        ids.append(int(name))
        waveforms.append(_load(Path(path)))
    camera, rate, shape = (
        (ROLLING, 30.0, Disc()) if options.shutter == 'rolling' else (GLOBAL, 60.0, LedGrid())
    )
    drive = paper_run(waveforms, camera=camera, seed=options.seed, rest=REST, shape=shape)
    return replace(drive, clock=CameraClock(CLOCK_RATIO * rate, JITTER)), ids


def _load(path: Path) -> Waveform:
    try:
        return waveform_from_csv(path.read_text(encoding='utf-8'))
    except (LightWaveformError, UnicodeDecodeError) as error:
        raise SceneError(f'{path}: {error}') from error
    except OSError as error:
        raise SceneError(f'{path}: cannot be read ({error.strerror}); give a waveform file') from error


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='record_lamp_bag', description=__doc__)
    parser.add_argument('bag', type=Path, help='folder of the bag to write')
    parser.add_argument(
        'lamp',
        nargs='+',
        metavar='ID=FILE.csv',
        help='ID and waveform of each lamp: at (0, 0), (0, 1.8), (1.8, 0) and (1.8, 1.8) m; '
        'the last one is A, the one before B',
    )
    parser.add_argument(
        '--shutter',
        default='global',
        choices=('global', 'rolling'),
        help='camera shutter; rolling: disc lamps, 30 Hz, full resolution (default: %(default)s)',
    )
    parser.add_argument(
        '--seed', type=int, default=0, help='seed of the room, noise and errors (default: %(default)s)'
    )
    parser.add_argument('--seconds', type=float, default=39.0, help='length [s] (default: %(default)s)')
    return parser


if __name__ == '__main__':
    sys.exit(main())
