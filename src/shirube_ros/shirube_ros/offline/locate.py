"""The command ``locate`` of the localizers: poses from images or a bag, without ROS running."""

# ruff: noqa: T201 the messages of a command

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from shirube_bags.errors import ShirubeBagsError
from shirube_bags.trajectory import planar_trajectory
from shirube_bags.trajectory_files import save_tum
from shirube_core import command
from shirube_core.geometry import SE2, PinholeCamera
from shirube_core.settings import SettingsError
from shirube_ros.camera.files import list_images, load_calibration, load_image
from shirube_ros.camera.info import SizedCamera
from shirube_ros.camera.settings import CameraSettings
from shirube_ros.errors import CameraFileError, MessageError
from shirube_ros.offline.recording import BadImage, RecordedImage, RecordedOdometry, Recording
from shirube_ros.stamps import StampValidator

Calibration = TypeVar('Calibration', bound=SizedCamera)
Result = TypeVar('Result')


def _ignore(*_: object) -> None:
    """Ignore messages that a localizer does not use."""


@dataclass(frozen=True)
class OfflineLocalizer(Generic[Calibration, Result]):
    """What a localizer does with the messages of a bag.

    Attributes:
        locate: returns the result of an image with its stamp [s]; None if there is none, as for half a stereo pair.
        add_odometry: takes a stamp [s] and the pose of the base in the odometry frame.
        add_tilt: takes a stamp [s], roll and pitch of the base [rad].
    """

    locate: Callable[[float, RecordedImage[Calibration]], Result | None]
    add_odometry: Callable[[float, SE2], None] = _ignore
    add_tilt: Callable[[float, float, float], None] = _ignore


def locate_recording(
    recording: Recording[Calibration],
    create: Callable[[], OfflineLocalizer[Calibration, Result]],
    image_errors: tuple[type[Exception], ...],
) -> Iterator[tuple[str, int, Result | str]]:
    """Yield topic, stamp [ns] and result of the images of a bag, located as in the node.

    The result is an error message if the image is malformed; other malformed messages are skipped.

    Raises:
        BagError: the bag is corrupted.
    """
    malformed: tuple[type[Exception], ...] = (MessageError, *image_errors)
    localizer = create()

    def restart() -> None:
        nonlocal localizer
        localizer = create()

    stamps = StampValidator(restart)
    for message in recording.messages():
        if isinstance(message, BadImage):
            yield message.topic, message.stamp_ns, message.fault
            continue
        result: Result | str | None = None
        try:
            # The stamp first: after a jump back in time, the message belongs to the new localizer.
            stamp = stamps.check(message.header, message.topic)
            if isinstance(message, RecordedImage):
                result = localizer.locate(stamp, message)
            elif isinstance(message, RecordedOdometry):
                localizer.add_odometry(stamp, message.T_odom_base)
            else:
                localizer.add_tilt(stamp, *message.tilt)
        except malformed as fault:
            result = str(fault)
        if result is not None and isinstance(message, RecordedImage):
            yield message.topic, message.stamp_ns, result


def locate_files(
    options: argparse.Namespace,
    create: Callable[[], Callable[[float, NDArray[np.uint8], PinholeCamera], Result]],
    rate: float = 1.0,
) -> list[tuple[str, int, Result]]:
    """Return name, stamp [ns] and result of the images of ``--images``; the stamp is the index over the rate.

    Args:
        options: options of `add_single_camera_options`.
        create: creates the localizer, which gets the stamp [s], the pixels and the camera of each image.
        rate: images per second.

    Raises:
        CameraFileError: a calibration or an image is missing or malformed.
        SettingsError: a rate of zero or less.
    """
    if options.calibration is None:
        raise CameraFileError('--calibration is missing; give the YAML that camera_calibration writes')
    if not rate > 0.0:
        raise SettingsError(f'--rate is {rate}, it must be above 0; give the images per second')
    camera, paths = load_calibration(options.calibration), list_images(options.images)
    locate = create()
    located = []
    for number, path in enumerate(tqdm(paths, unit='image', disable=None)):
        pixels = load_image(path)
        height, width = pixels.shape[:2]
        if (width, height) != (camera.width, camera.height):
            raise CameraFileError(
                f'{path}: is {width} x {height} px, the calibration is for '
                f'{camera.width} x {camera.height} px; calibrate at this resolution'
            )
        stamp = number / rate
        located.append((str(path), round(stamp * 1e9), locate(stamp, pixels, camera)))
    return located


def save_poses(path: Path, poses: Mapping[int, SE2]) -> int:
    """Write the poses by stamp [ns], if there are any, as a TUM file and return their number."""
    if poses:
        flat = [(pose.x, pose.y, pose.yaw) for pose in poses.values()]
        save_tum(path, planar_trajectory(list(poses), flat))
    else:
        path.unlink(missing_ok=True)
    return len(poses)


def run_command(work: Callable[[], tuple[Sequence[str], str]], errors: tuple[type[Exception], ...], out: Path) -> int:
    """Do the work of a command, print its report and return the exit code; errors are one line.

    Args:
        work: locates, writes the files and returns the report, and a fault if there is no pose at all, else ``''``.
        errors: errors of the package for malformed files.
        out: output folder.
    """

    def locate() -> int:
        report, fault = work()
        for line in report:
            print(line)
        if fault:
            print(f'locate: {fault}', file=sys.stderr)
        return 1 if fault else 0

    return command.run_command('locate', locate, (*errors, CameraFileError, ShirubeBagsError, SettingsError), out)


def add_single_camera_options(parser: argparse.ArgumentParser, in_bag: str) -> None:
    """Add ``--images`` or ``--bag``, whose contents ``in_bag`` names, and ``--calibration``."""
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--images', type=Path, nargs='+', help='a folder of images, or images in order')
    source.add_argument('--bag', type=Path, help=f'rosbag2 with images, camera_info and {in_bag}')
    parser.add_argument('--calibration', type=Path, metavar='YAML',
        help='calibration of the images, as camera_calibration writes it')  # fmt: skip


def add_common_options(
    parser: argparse.ArgumentParser, topics: Sequence[str], camera: CameraSettings, direction: str
) -> None:
    """Add the topics of the bag, the output folder and the camera extrinsics with their defaults."""
    add: Callable[..., Any] = parser.add_argument
    for name in topics:
        add(f'--{name}', metavar='TOPIC', help='topic of the bag (default: the usual or the only one)')
    add('--out', type=Path, default=Path('out/locate'), metavar='FOLDER', help='default: %(default)s')
    add_mount_options(parser, camera, direction)


def add_mount_options(parser: argparse.ArgumentParser, camera: CameraSettings, direction: str) -> None:
    """Add the camera extrinsics with their defaults, whose direction the help names."""
    add: Callable[..., Any] = parser.add_argument
    add('--camera-xyz', type=float, nargs=3, default=camera.camera_xyz, metavar=('X', 'Y', 'Z'),
        help='position of the optical frame in the base frame [m] (default: %(default)s)')  # fmt: skip
    add('--camera-rpy', type=float, nargs=3, default=camera.camera_rpy, metavar=('R', 'P', 'Y'),
        help=f'its fixed-axis roll, pitch, yaw in the base frame [rad] (default: {direction})')  # fmt: skip
