"""``locate``: poses from a beacons file and images or a bag, without ROS running."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ShirubeBagsError
from shirube_bags.trajectory import planar_trajectory
from shirube_bags.tum_file import save_tum
from shirube_core.geometry import PinholeCamera
from shirube_core.settings import SettingsError, check_settings, reject_former_option
from shirube_ros.calibration_file import load_calibration
from shirube_ros.file_errors import CameraFileError
from shirube_ros.image_files import list_images, load_image
from vlc_beacon.bag_localization import BagLocalization, choose_topics
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.pose_table import LocatedImage, save_pose_table
from vlc_beacon.node_settings import NodeSettings, authorizer_from_settings, beacons_from_settings

_NODE, _LIGHT = NodeSettings(), ReceiverSettings()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file is invalid or no image gave a pose."""
    options = make_parser().parse_args(arguments)
    try:
        images = locate(options)
        save_pose_table(options.out / 'poses.csv', images)
        fixes = save_fixes(options.out / 'poses.tum', images)
    except (VlcBeaconError, CameraFileError, ShirubeBagsError, SettingsError) as error:
        print(f'locate: {error}', file=sys.stderr)
        return 1
    except OSError as error:
        print(f'locate: {error.filename}: {error.strerror}; choose a writable path', file=sys.stderr)
        return 1
    print(f'{fixes} of {len(images)} images have a pose; see {options.out / "poses.csv"}')
    for failure, number in Counter(image.failure for image in images if image.failure).most_common():
        print(f'{number} without a pose: {failure}')
    if fixes == 0:
        print(
            'locate: no image gave a pose; check beacons, shutter, exposure time and camera', file=sys.stderr
        )
    return 0 if fixes else 1


def locate(options: argparse.Namespace) -> list[LocatedImage]:
    """Return the results of all images, in order."""
    if options.bag is not None:
        return locate_bag(options)
    if options.calibration is None:
        raise CameraFileError('--calibration is missing; give the YAML that camera_calibration writes')
    if not options.rate > 0.0:
        raise SettingsError(f'--rate is {options.rate}, it must be above 0; give the images per second')
    camera, paths = load_calibration(options.calibration), list_images(options.images)
    images = locate_files(create_receiver(options), camera, paths, options.rate)
    return list(tqdm(images, total=len(paths), unit='image', disable=None))


def create_receiver(options: argparse.Namespace) -> BeaconReceiver:
    """Return a new receiver for poses only; it has no key, so it rejects all commands."""
    node = NodeSettings(
        beacons_file=str(options.beacons),
        camera_xyz=tuple(options.camera_xyz),
        camera_rpy=tuple(options.camera_rpy),
    )
    light = ReceiverSettings(
        shutter=options.shutter,
        row_time=options.row_time,
        exposure_time=options.exposure_time,
        lamp_frame_rate=options.lamp_frame_rate,
        segment_bytes=options.segment_bytes,
        method=options.method,
        camera_height_known=options.camera_height_known,
        blooming=options.blooming,
    )
    check_settings(node)
    check_settings(light)
    beacons = beacons_from_settings(node)
    return BeaconReceiver(
        beacons, node.mount, authorizer_from_settings(node, AuthorizationSettings(), beacons), light
    )


def locate_files(
    receiver: BeaconReceiver, camera: PinholeCamera, paths: Sequence[Path], rate: float
) -> Iterator[LocatedImage]:
    """Yield the result of each image of a sequence with the given frame rate [1/s]."""
    for number, path in enumerate(paths):
        pixels = load_image(path)
        height, width = pixels.shape[:2]
        if (width, height) != (camera.width, camera.height):
            raise CameraFileError(
                f'{path}: is {width} x {height} px, the calibration is for '
                f'{camera.width} x {camera.height} px; calibrate at this resolution'
            )
        stamp = number / rate
        yield LocatedImage(str(path), round(stamp * 1e9), receiver.receive(stamp, pixels, camera))


def locate_bag(options: argparse.Namespace) -> list[LocatedImage]:
    """Return the results of a bag's images, located as in the node."""
    with BagReader(options.bag) as bag:
        names = (options.topic, options.camera_info_topic, options.odom_topic, options.imu_topic)
        topics = choose_topics(bag, *names)
        images = BagLocalization(bag, topics, lambda: create_receiver(options)).run()
        total = bag.topics[topics.images[0]].message_count
        return list(tqdm(images, total=total, unit='image', disable=None))


def save_fixes(path: Path, images: Sequence[LocatedImage]) -> int:
    """Write the poses as a TUM file, if any, and return their number."""
    poses = {image.stamp_ns: image.fix.T_map_base for image in images if image.fix is not None}
    if poses:
        flat = [(pose.x, pose.y, pose.yaw) for pose in poses.values()]
        save_tum(path, planar_trajectory(list(poses), flat))
    else:
        path.unlink(missing_ok=True)
    return len(poses)


def make_parser() -> argparse.ArgumentParser:
    """Return the command-line parser."""
    parser = argparse.ArgumentParser(
        prog='locate',
        description='Compute the poses of an image sequence under beacons, given as images or a bag. '
        'Writes poses.tum, and poses.csv with the failure reason of images without a pose.',
    )
    add = parser.add_argument
    add('--beacons', type=Path, required=True, metavar='YAML', help='beacons file: lamps and their positions')
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--images', type=Path, nargs='+', help='a folder of images, or images in order')
    source.add_argument('--bag', type=Path, help='rosbag2 with images, camera_info and optional odom and imu')
    add(
        '--calibration',
        type=Path,
        metavar='YAML',
        help='calibration of the images, as camera_calibration writes it',
    )
    add(
        '--rate',
        type=float,
        default=60.0,
        help='frame rate of a folder of images [1/s] (default: %(default)s)',
    )
    for name, what in (('topic', 'images'), ('camera-info-topic', 'calibration'), ('odom-topic', 'odometry'),
                       ('imu-topic', 'inertial unit')):  # fmt: skip
        add(
            f'--{name}',
            metavar='TOPIC',
            help=f'topic of the {what} in the bag (default: the usual or the only one)',
        )
    add('--out', type=Path, default=Path('out/locate'), metavar='FOLDER', help='default: %(default)s')
    _add_camera_options(parser)
    return parser


def _add_camera_options(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add('--camera-xyz', type=float, nargs=3, default=_NODE.camera_xyz, metavar=('X', 'Y', 'Z'),
        help='position of the optical frame in the base frame [m] (default: %(default)s)')  # fmt: skip
    add('--camera-rpy', type=float, nargs=3, default=_NODE.camera_rpy, metavar=('R', 'P', 'Y'),
        help='its fixed-axis roll, pitch, yaw in the base frame [rad] (default: looking up)')  # fmt: skip
    add('--shutter', default=_LIGHT.shutter, help='global or rolling (default: %(default)s)')
    add(
        '--row-time',
        type=float,
        default=_LIGHT.row_time,
        help='line time of a rolling shutter [s] (default: %(default)s)',
    )
    add(
        '--exposure-time',
        type=float,
        default=_LIGHT.exposure_time,
        help='exposure [s] (default: %(default)s)',
    )
    add('--lamp-frame-rate', type=float, default=_LIGHT.lamp_frame_rate,
        help='frame rate the lamps were encoded for, rolling shutter only [1/s] (default: %(default)s)')  # fmt: skip
    add(
        '--segment-bytes',
        type=int,
        default=_LIGHT.segment_bytes,
        help='bytes per Manchester segment (default: %(default)s)',
    )
    reject_former_option(parser, 'slot_bytes', 'segment_bytes')
    add('--blooming', type=float, default=_LIGHT.blooming,
        help='blooming: increase of the lamp radius, beta of calibrate [px] (default: %(default)s)')  # fmt: skip
    add('--method', default=_LIGHT.method,
        help='centroid, radius_interval or radius_interval_printed (default: %(default)s)')  # fmt: skip
    add('--camera-height-known', action='store_true', help='the base frame is on the floor z = 0 of the map')


if __name__ == '__main__':
    sys.exit(main())
