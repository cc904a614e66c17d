"""``render_stereo_pair``: write what a stereo rig sees of a corridor: two pictures, their calibration, the points.

``left.png``, ``right.png``, ``left.yaml`` and ``right.yaml`` are what a camera driver and camera_calibration would
write; ``points.csv`` holds the true map position of each point that can be taught.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_generator import CorridorDesign, corridor
from scene_simulator.corridor_recordings import TAUGHT_POSE
from scene_simulator.errors import SceneError
from scene_simulator.stereo_calibration import calibration_yaml
from scene_simulator.stereo_rig import StereoRig, raw_rig, render_pair
from shirube_core.files import write_text
from shirube_core.geometry import SE2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when an option is bad or a file cannot be written."""
    options = _parser().parse_args(arguments)
    try:
        design = CorridorDesign(options.seed, people=options.people, needles=options.needles)
        _write_pair(options.folder, design, raw_rig() if options.raw else StereoRig(), SE2(*options.pose))
    except SceneError as error:
        print(f'render_stereo_pair: {error}', file=sys.stderr)
        return 1
    except OSError as error:
        print(
            f'render_stereo_pair: {options.folder}: cannot be written ({error.strerror}); choose a writable place',
            file=sys.stderr,
        )
        return 1
    print(f'{options.folder}: a pair of pictures from {options.pose}')
    return 0


def _write_pair(folder: Path, design: CorridorDesign, rig: StereoRig, T_map_base: SE2) -> None:
    """Write pictures, calibration and points."""
    scene, rng = corridor(design), np.random.default_rng((design.seed, design.needles))
    folder.mkdir(parents=True, exist_ok=True)
    pictures, calibrations = render_pair(scene, rig, T_map_base, rng), rig.calibrations()
    for side, picture, calibration in zip(('left', 'right'), pictures, calibrations, strict=True):
        (folder / f'{side}.png').write_bytes(_png(picture))
        write_text(folder / f'{side}.yaml', calibration_yaml(calibration, side))
    rows = [f'{name},{x:.6f},{y:.6f},{z:.6f}\n' for name, (x, y, z) in scene.points_map().items()]
    write_text(folder / 'points.csv', ''.join(['name,x,y,z\n', *rows]))


def _png(picture: NDArray[np.uint8]) -> bytes:
    return bytes(cv2.imencode('.png', picture)[1])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='render_stereo_pair', description=__doc__)
    parser.add_argument('folder', type=Path, help='output folder; existing files are overwritten')
    parser.add_argument('--seed', type=int, default=0, help='seed of the corridor (default: %(default)s)')
    parser.add_argument(
        '--needles', type=int, default=0, help='seed of the meter readings (default: %(default)s)'
    )
    parser.add_argument('--people', type=int, default=0, help='people in the corridor (default: %(default)s)')
    parser.add_argument(
        '--pose',
        type=float,
        nargs=3,
        metavar=('X', 'Y', 'YAW'),
        default=[TAUGHT_POSE.x, TAUGHT_POSE.y, TAUGHT_POSE.yaw],
        help='pose of the robot in the map, whose plane x = 0 is the end wall [m, rad] (default: %(default)s)',
    )
    parser.add_argument('--raw', action='store_true', help='raw (distorted) images instead of rectified ones')
    return parser


if __name__ == '__main__':
    sys.exit(main())
