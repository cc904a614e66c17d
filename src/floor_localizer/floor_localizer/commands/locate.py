"""``locate``: computes poses from a dot map and images or a bag, without ROS running."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from tqdm import tqdm

from floor_localizer.bag_localization import BagLocalization, choose_topics
from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.tracker import FloorTracker
from floor_localizer.files.pose_table import LocatedImage, save_pose_table
from floor_localizer.localization.localizer_from_map_file import (
    STARTUP_NOTICE,
    NodeSettings,
    localizer_from_map_file,
)
from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ShirubeBagsError
from shirube_bags.trajectory import planar_trajectory
from shirube_bags.tum_file import save_tum
from shirube_core.geometry import PinholeCamera
from shirube_core.settings import SettingsError, check_settings
from shirube_ros.calibration_file import load_calibration
from shirube_ros.file_errors import CameraFileError
from shirube_ros.image_files import list_images, load_image

_DEFAULTS = NodeSettings()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 for an invalid file or if no image has a pose."""
    options = make_parser().parse_args(arguments)
    try:
        images = locate(options)
        save_pose_table(options.out / 'poses.csv', images)
        fixes = save_fixes(options.out / 'poses.tum', images)
    except (FloorLocalizerError, CameraFileError, ShirubeBagsError, SettingsError) as fault:
        print(f'locate: {fault}', file=sys.stderr)
        return 1
    except OSError as fault:
        print(f'locate: {fault.filename}: {fault.strerror}; choose a writable place', file=sys.stderr)
        return 1
    print(f'{fixes} of {len(images)} images have a pose; see {options.out / "poses.csv"}')
    for failure, number in Counter(image.failure for image in images if image.failure).most_common():
        print(f'{number} without a pose: {failure}')
    if fixes == 0:
        print('locate: no image has a pose; check map, calibration and camera_xyz', file=sys.stderr)
    return 0 if fixes else 1


def locate(options: argparse.Namespace) -> list[LocatedImage]:
    """Return the results of all images, in order."""
    settings = NodeSettings(
        map_file=str(options.map), camera_xyz=tuple(options.camera_xyz), camera_rpy=tuple(options.camera_rpy)
    )
    check_settings(settings)
    if options.bag is not None:
        return locate_bag(options, settings)
    if options.calibration is None:
        raise FloorLocalizerError('--calibration is missing; give the YAML that camera_calibration writes')
    camera, paths = load_calibration(options.calibration), list_images(options.images)
    localizer = load_localizer(settings)
    return list(tqdm(locate_files(localizer, camera, paths), total=len(paths), unit='image', disable=None))


def load_localizer(settings: NodeSettings) -> FloorLocalizer:
    """Return the localizer, with compiled kernels."""
    print(STARTUP_NOTICE, file=sys.stderr)
    return localizer_from_map_file(settings, LocalizerSettings(), partial(print, file=sys.stderr))


def locate_files(
    localizer: FloorLocalizer, camera: PinholeCamera, paths: Sequence[Path]
) -> Iterator[LocatedImage]:
    """Yield the result of each image, located independently; its index in seconds is its stamp."""
    for number, path in enumerate(paths):
        pixels = load_image(path)
        height, width = pixels.shape[:2]
        if (width, height) != (camera.width, camera.height):
            raise FloorLocalizerError(
                f'{path}: is {width} x {height} px, the calibration is for '
                f'{camera.width} x {camera.height} px; calibrate at this resolution'
            )
        yield LocatedImage(str(path), number * 1_000_000_000, localizer.locate(pixels, camera))


def locate_bag(options: argparse.Namespace, settings: NodeSettings) -> list[LocatedImage]:
    """Return the results of a bag's images, located with tracking as in the node."""
    with BagReader(options.bag) as bag:
        topics = choose_topics(bag, options.topic, options.camera_info_topic, options.odom_topic)
        create_tracker = partial(FloorTracker, load_localizer(settings), settings.tracker)
        images = BagLocalization(bag, topics, create_tracker).run()
        total = bag.topics[topics.images[0]].message_count
        return list(tqdm(images, total=total, unit='image', disable=None))


def save_fixes(path: Path, images: Sequence[LocatedImage]) -> int:
    """Write the poses, if there are any, as a TUM file and return their number."""
    fixes = {image.stamp_ns: image.result.T_map_base for image in images if isinstance(image.result, Fix)}
    if fixes:
        save_tum(
            path, planar_trajectory(list(fixes), [(pose.x, pose.y, pose.yaw) for pose in fixes.values()])
        )
    else:
        path.unlink(missing_ok=True)
    return len(fixes)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='locate',
        description='Compute the poses of images on a dot map: single images independently, a bag with tracking as in '
        'the node. Writes poses.tum, and poses.csv with the reason for each image without a pose.',
    )
    add = parser.add_argument
    add('--map', type=Path, required=True, help='dot map, CSV or .dotmap')
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--images', type=Path, nargs='+', help='a folder of images, or images')
    source.add_argument('--bag', type=Path, help='rosbag2 with images, camera_info and perhaps odom')
    add(
        '--calibration',
        type=Path,
        metavar='YAML',
        help='calibration of the images, as written by camera_calibration',
    )
    add('--topic', help='image topic of the bag (default: /image_raw or the only one)')
    add(
        '--camera-info-topic',
        metavar='TOPIC',
        help='calibration topic of the bag (default: /camera_info or the only one)',
    )
    add(
        '--odom-topic',
        metavar='TOPIC',
        help='odometry topic of the bag (default: /odom or the only one, if any)',
    )
    add('--out', type=Path, default=Path('out/locate'), metavar='FOLDER', help='default: %(default)s')
    add('--camera-xyz', type=float, nargs=3, default=_DEFAULTS.camera_xyz, metavar=('X', 'Y', 'Z'),
        help='position of the optical frame in the base frame [m] (default: %(default)s)')  # fmt: skip
    add('--camera-rpy', type=float, nargs=3, default=_DEFAULTS.camera_rpy, metavar=('R', 'P', 'Y'),
        help='fixed-axis roll, pitch, yaw of the optical frame [rad] (default: looking down)')  # fmt: skip
    return parser


if __name__ == '__main__':
    sys.exit(main())
