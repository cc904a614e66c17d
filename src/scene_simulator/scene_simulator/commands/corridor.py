"""Commands of the corridor: record a drive with a stereo rig as a bag with ground truth, write what the rig sees."""

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from scene_simulator import messages
from scene_simulator.commands.recording import Entry, bag_parser, run_recording, stamp_at, write_drive
from scene_simulator.corridor.generator import CorridorDesign, corridor
from scene_simulator.corridor.stereo_drive import (
    RUNS,
    SECONDS,
    TAUGHT_POSE,
    StereoDrive,
    StereoFrame,
    make_corridor_drive,
)
from scene_simulator.corridor.stereo_rig import StereoRig, raw_rig, render_pair
from scene_simulator.errors import SceneError
from shirube_core.command import run_command
from shirube_core.files import write_text
from shirube_core.geometry import SE2
from shirube_ros.camera.files import calibration_text

JPEG_QUALITY = 85


def record_stereo_bag(arguments: Sequence[str] | None = None) -> int:
    """``record_stereo_bag``: render a drive in a corridor with meters as a bag; the same seed gives the same bag."""
    parser = bag_parser('record_stereo_bag', record_stereo_bag.__doc__, SECONDS, 0, 'the corridor')
    parser.add_argument('run', choices=RUNS, help='which drive')
    parser.add_argument('--raw', action='store_true', help='raw (distorted) images instead of rectified ones')
    options = parser.parse_args(arguments)

    def record() -> tuple[Iterator[int], int, str]:
        rig = raw_rig() if options.raw else StereoRig()
        drive = make_corridor_drive(options.run, CorridorDesign(options.seed), rig)
        pairs = record_stereo_drive(drive, options.bag, options.seconds)
        line = f'{options.bag}: {options.seconds} s of the run {options.run!r}'
        return pairs, drive.frame_count(options.seconds), line

    return run_recording('record_stereo_bag', record, 'pair')


def record_stereo_drive(drive: StereoDrive, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive as a bag with ground truth; yield the number of each pair after it is written.

    Rectified images are on ``image_rect``, those of a rig that distorts on ``image_raw``.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive.
    """
    name = 'image_rect' if drive.rig.is_rectified else 'image_raw'
    drive.frame_count(seconds)  # refuses a bad length
    images = (entry for frame in drive.frames(seconds) for entry in _frame_entries(drive, frame, name))
    return write_drive(path, drive, seconds, f'/right/{name}/compressed', images)


def _frame_entries(drive: StereoDrive, frame: StereoFrame, name: str) -> Iterator[Entry]:
    """Yield the true pose, and calibration and image of the left and of the right camera."""
    stamp = stamp_at(frame.stamp)
    truth = messages.pose_stamped(frame.pose, 'map', stamp)
    yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
    calibrations = drive.rig.calibrations()
    for side, image, found in zip(('left', 'right'), (frame.left, frame.right), calibrations, strict=True):
        camera = f'{side}_camera_optical_frame'
        info = messages.camera_info(found.camera, camera, stamp, found.rotation, found.projection)
        jpeg = messages.compressed_image(image, camera, stamp, JPEG_QUALITY, progressive=True)
        yield stamp, f'/{side}/camera_info', 'sensor_msgs/msg/CameraInfo', info
        yield stamp, f'/{side}/{name}/compressed', 'sensor_msgs/msg/CompressedImage', jpeg


def render_stereo_pair(arguments: Sequence[str] | None = None) -> int:
    """``render_stereo_pair``: write what a stereo rig sees of a corridor: two pictures, their calibration, the points.

    ``left.png``, ``right.png``, ``left.yaml`` and ``right.yaml`` are what a camera driver and camera_calibration would
    write; ``points.csv`` holds the true map position of each point that can be taught.
    """
    options = _pair_parser().parse_args(arguments)

    def work() -> None:
        design = CorridorDesign(options.seed, people=options.people)
        _write_pair(options.folder, design, raw_rig() if options.raw else StereoRig(), SE2(*options.pose))
        print(f'{options.folder}: a pair of pictures from {options.pose}')

    return run_command('render_stereo_pair', work, (SceneError,), options.folder)


def _write_pair(folder: Path, design: CorridorDesign, rig: StereoRig, T_map_base: SE2) -> None:
    """Write pictures, calibration and points."""
    scene, rng = corridor(design), np.random.default_rng((design.seed, design.needles))
    folder.mkdir(parents=True, exist_ok=True)
    pictures, calibrations = render_pair(scene, rig, T_map_base, rng), rig.calibrations()
    for side, picture, calibration in zip(('left', 'right'), pictures, calibrations, strict=True):
        (folder / f'{side}.png').write_bytes(bytes(cv2.imencode('.png', picture)[1]))
        text = calibration_text(side, calibration.camera, calibration.rotation, calibration.projection)
        write_text(folder / f'{side}.yaml', text)
    rows = [f'{name},{x:.6f},{y:.6f},{z:.6f}\n' for name, (x, y, z) in scene.points_map().items()]
    write_text(folder / 'points.csv', ''.join(['name,x,y,z\n', *rows]))


def _pair_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='render_stereo_pair', description=render_stereo_pair.__doc__)
    parser.add_argument('folder', type=Path, help='output folder; existing files are overwritten')
    parser.add_argument('--seed', type=int, default=0, help='seed of the corridor (default: %(default)s)')
    parser.add_argument('--people', type=int, default=0, help='people in the corridor (default: %(default)s)')
    pose, names = [TAUGHT_POSE.x, TAUGHT_POSE.y, TAUGHT_POSE.yaw], ('X', 'Y', 'YAW')
    about = 'pose of the robot in the map, whose plane x = 0 is the end wall [m, rad] (default: %(default)s)'
    parser.add_argument('--pose', type=float, nargs=3, metavar=names, default=pose, help=about)
    parser.add_argument('--raw', action='store_true', help='raw (distorted) images instead of rectified ones')
    return parser
