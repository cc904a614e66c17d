"""Commands of the floor: lay a floor and write its dot map, record the demo drive over it."""

import argparse
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene_simulator import messages
from scene_simulator.commands.recording import (
    START_NS,
    Entry,
    bag_parser,
    odometry_of_drive,
    run_recording,
    write_entries,
)
from scene_simulator.errors import SceneError
from scene_simulator.floor.demo_scene import DEMO_FLOOR_SEED, DemoScene
from scene_simulator.floor.dot_floor import DARK_ON_LIGHT, SURVEY_ERROR, generate_dot_floor, survey_floor
from shirube_core.command import run_command
from shirube_core.files import atomic_write

CAMERA_FRAME = 'belly_camera_optical_frame'
DIRTY_FRACTION = 0.05
"""An image is marked dirty when dirt hides more than this fraction of the view, twice the area of its chips."""

_IMAGE_NOISE, _WHEEL_NOISE = 1, 2
_IMAGE_PERIOD_NS = 100_000_000


def generate_floor(arguments: Sequence[str] | None = None) -> int:
    """``generate_floor``: lay a floor of random chips and write its dot map; by default the demo's floor."""
    options = _floor_parser().parse_args(arguments)
    design = replace(DARK_ON_LIGHT, size=tuple(options.size), count=options.count)

    def work() -> None:
        dots = survey_floor(generate_dot_floor(design, options.seed), SURVEY_ERROR, options.seed + 1)
        write_dot_map(dots, options.map)
        print(f'{options.map}: {len(dots)} dots on {design.size[0]} x {design.size[1]} m')

    return run_command('generate_floor', work, (SceneError,), options.map)


def _floor_parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='generate_floor', description=generate_floor.__doc__)
    parser.add_argument('map', type=Path, help='CSV file to write: x,y,diameter in metres')
    size, about = DARK_ON_LIGHT.size, 'extent of the floor [m] (default: %(default)s)'
    parser.add_argument('--size', type=float, nargs=2, metavar=('X', 'Y'), default=size, help=about)
    parser.add_argument('--count', type=int, default=DARK_ON_LIGHT.count, help='number of chips (default: %(default)s)')
    parser.add_argument('--seed', type=int, default=DEMO_FLOOR_SEED, help='seed of the floor (default: %(default)s)')
    return parser


def write_dot_map(dots: NDArray[np.float64], path: Path) -> None:
    """Write a dot map, shape (n, 3), as CSV with the header ``x,y,diameter``, complete or not at all.

    Numbers are written to the micrometre; an existing file is replaced; raises `OSError`.
    """
    with atomic_write(path) as file:
        np.savetxt(file, dots, fmt='%.6f', delimiter=',', header='x,y,diameter', comments='')


def record_floor_bag(arguments: Sequence[str] | None = None) -> int:
    """``record_floor_bag``: render the demo drive and write it as a bag; the same seed gives the same bag."""
    use = 'dirt, noise and suspension'
    parser = bag_parser('record_floor_bag', record_floor_bag.__doc__, 60.0, DemoScene.seed, use)
    options = parser.parse_args(arguments)

    def record() -> tuple[Iterator[int], int, str]:
        images = record_drive(DemoScene(options.seed), options.bag, options.seconds)
        line = f'{options.bag}: {options.seconds} s of the demo drive'
        return images, len(_image_times(options.seconds)), line

    return run_recording('record_floor_bag', record, 'image')


def record_drive(scene: DemoScene, path: Path, seconds: float) -> Iterator[int]:
    """Record a drive as a bag with ground truth; yield the number of each image after it is written.

    Raises:
        BagError: the bag cannot be written.
        SceneError: the length is not positive.
    """
    images = (entry for image in enumerate(_image_times(seconds)) for entry in _image_entries(scene, *image))
    odometry = odometry_of_drive(scene.pose_at, seconds, np.random.default_rng((scene.seed, _WHEEL_NOISE)))
    return write_entries(path, '/image_raw/compressed', odometry, images)


def _image_times(seconds: float) -> range:
    """Return the times of the images since the start [ns], or raise SceneError where there is none."""
    if not 0.0 < seconds < math.inf:
        raise SceneError(f'the recording is {seconds} s long: give a positive number of seconds')
    return range(0, round(seconds * 1e9), _IMAGE_PERIOD_NS)


def _image_entries(scene: DemoScene, index: int, time_ns: int) -> Iterator[Entry]:
    """Yield the true pose at the middle of an image's exposure, its dirt mark, its calibration, and the image."""
    stamp = START_NS + time_ns
    photo = scene.photograph(time_ns / 1e9, np.random.default_rng((scene.seed, _IMAGE_NOISE, index)))
    truth = messages.pose_stamped(scene.pose_at(time_ns / 1e9), 'map', stamp)
    info = messages.camera_info(scene.camera.intrinsics, CAMERA_FRAME, stamp)
    image = messages.compressed_image(photo.image, CAMERA_FRAME, stamp)
    yield stamp, '/ground_truth', 'geometry_msgs/msg/PoseStamped', truth
    yield stamp, '/dirt', 'std_msgs/msg/Bool', messages.flag(photo.dirt_fraction > DIRTY_FRACTION)
    yield stamp, '/camera_info', 'sensor_msgs/msg/CameraInfo', info
    yield stamp, '/image_raw/compressed', 'sensor_msgs/msg/CompressedImage', image
