"""``survey``: beacon positions from a recorded drive with known poses."""

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import BagError, ShirubeBagsError
from shirube_bags.trajectory import can_interpolate, interpolate
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps
from shirube_core.command import add_settings, run_command
from shirube_core.geometry import CameraMount, PinholeCamera
from shirube_core.settings import SettingsError, check_settings
from shirube_ros.camera.image import array_from_compressed_image, array_from_image, to_grey
from shirube_ros.camera.info import camera_from_camera_info, check_image_size
from shirube_ros.errors import MessageError
from shirube_ros.offline.locate import add_mount_options
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.settings import PoseSettings, ReceiverSettings
from vlc_beacon.core.survey.beacon_survey import BearingCollector, NotSurveyed, SurveyedLamp, survey_lamp
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.beacons_file import RADIUS_RANGE, save_beacons
from vlc_beacon.node_settings import NodeSettings

_NANOSECONDS = 1e9
_GAP_MAX_NS = 200_000_000
"""Maximum gap between poses for interpolation."""


@dataclass(frozen=True)
class DriveTopics:
    """Topics of the bag; without an IMU, whose orientation gives roll and pitch, those of the pose are used."""

    image: str
    camera_info: str
    pose: str
    imu: str


@dataclass(frozen=True)
class DriveImage:
    """An image with a known camera pose.

    Attributes:
        stamp: time since the first image [s].
        pixels: grey image, shape (h, w).
        position: camera position in the map, shape (3,) [m].
        rotation: camera rotation ``R_map_camera``, shape (3, 3).
    """

    stamp: float
    pixels: NDArray[np.uint8]
    position: NDArray[np.float64]
    rotation: NDArray[np.float64]


def load_camera(bag: BagReader, topic: str) -> PinholeCamera:
    """Return the calibration of a bag's images; raises `BagError` or `CameraInfoError`."""
    for raw in bag.messages([topic]):
        return camera_from_camera_info(bag.decode(raw), topic)
    raise BagError(f'{bag.path}: {topic} is empty; record the calibration too')


def drive_images(
    bag: BagReader, topics: DriveTopics, mount: CameraMount, camera: PinholeCamera
) -> Iterator[DriveImage]:
    """Yield the images of an open bag with known poses.

    Raises:
        BagError: a topic is missing or corrupted, or no image has a pose.
        MessageError: an image cannot be decoded.
    """
    stamps = load_header_stamps(bag, topics.image)
    known, positions, rotations = _base_poses(bag, topics, stamps)
    if not known.any():
        raise BagError(f'{bag.path}: {topics.pose} has no pose at the stamp of any image; use another topic')
    camera_positions = positions + rotations @ np.array(mount.xyz)
    orientations = rotations @ mount.rotation
    indices = np.cumsum(known) - 1
    for number, raw in enumerate(bag.messages([topics.image])):
        if known[number]:
            k = indices[number]
            seconds = float((stamps[number] - stamps[0]) / _NANOSECONDS)
            pixels = _grey(bag.decode(raw), raw.msgtype, topics.image)
            check_image_size(camera, pixels.shape, topics.image, topics.camera_info)
            yield DriveImage(seconds, pixels, camera_positions[k], orientations[k])


def _base_poses(
    bag: BagReader, topics: DriveTopics, stamps: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64], NDArray[np.float64]]:
    """Return the mask of stamps with a pose, and positions (n, 3) and ``R_map_base`` (n, 3, 3) at them."""
    trajectory = load_bag_trajectory(bag, topics.pose)
    known = can_interpolate(trajectory, stamps, _GAP_MAX_NS)
    tilts = _load_tilts(bag, topics.imu) if topics.imu else None
    if tilts is not None:
        known &= (tilts[0][0] <= stamps) & (stamps <= tilts[0][-1])
    poses = interpolate(trajectory, stamps[known])
    orientations = Rotation.from_quat(poses.quaternions)
    if tilts is not None and known.any():
        # Yaw is from the planar pose, roll and pitch from the IMU.
        times = (stamps[known] - tilts[0][0]) / _NANOSECONDS
        imu_times = (tilts[0] - tilts[0][0]) / _NANOSECONDS
        roll, pitch = (np.interp(times, imu_times, axis) for axis in tilts[1].T)
        yaws = orientations.as_euler('xyz')[:, 2]
        orientations = Rotation.from_euler('xyz', np.column_stack([roll, pitch, yaws]))
    return known, poses.positions, orientations.as_matrix()


def _load_tilts(bag: BagReader, topic: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return stamps (n,) [ns] and roll and pitch (n, 2) [rad]."""
    stamps = load_header_stamps(bag, topic)
    orientations = [bag.decode(raw).orientation for raw in bag.messages([topic])]
    if not orientations:
        raise BagError(f'{bag.path}: {topic} is empty; use another topic')
    quaternions = np.array([(turn.x, turn.y, turn.z, turn.w) for turn in orientations])
    if not (np.isfinite(quaternions).all() and np.abs(quaternions).max(axis=1).min() > 0.0):
        raise BagError(f'{bag.path}: {topic} has no orientation; use another topic, or none with ""')
    return stamps, Rotation.from_quat(quaternions).as_euler('xyz')[:, :2]


def _grey(message: object, msgtype: str, topic: str) -> NDArray[np.uint8]:
    convert = array_from_compressed_image if msgtype.endswith('CompressedImage') else array_from_image
    return to_grey(convert(message, topic))


_IMU_TOPIC = '/imu'
_LIGHT_OPTIONS = ('shutter', 'row_time', 'exposure_time', 'lamp_frame_rate')


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when the bag is invalid or no lamp was found."""
    options = make_parser().parse_args(arguments)
    errors = (VlcBeaconError, ShirubeBagsError, MessageError, SettingsError)
    return run_command('survey', lambda: survey_and_save(options), errors)


def survey_and_save(options: argparse.Namespace) -> None:
    """Survey the lamps and write the beacons file; raise a VlcBeaconError if no lamp was found."""
    results = survey(options)
    found = {beacon: lamp for beacon, lamp in results.items() if isinstance(lamp, SurveyedLamp)}
    if not found:
        raise VlcBeaconError(f'{options.bag}: no lamp was surveyed; see the lines above')
    beacons = [Beacon(beacon, lamp.xyz, options.lamp_radius) for beacon, lamp in found.items()]
    save_beacons(options.out, beacons)
    print(f'{len(found)} lamps; see {options.out}')


def survey(options: argparse.Namespace) -> Mapping[int, SurveyedLamp | NotSurveyed]:
    """Triangulate each lamp whose ID was decoded, print the results and return them."""
    mount = CameraMount(tuple(options.camera_xyz), tuple(options.camera_rpy))
    light = ReceiverSettings(**{name: getattr(options, name) for name in _LIGHT_OPTIONS})
    check_settings(light)
    low, high = RADIUS_RANGE
    if not low <= options.lamp_radius <= high:
        raise VlcBeaconError(
            f'--lamp-radius is {options.lamp_radius:g} m, it must be from {low:g} to {high:g}; is it in metres?'
        )
    with BagReader(options.bag) as bag:
        imu_topic = options.imu_topic
        if imu_topic is None:
            imu_topic = _IMU_TOPIC if _IMU_TOPIC in bag.topics else ''
        topics = DriveTopics(options.image_topic, options.camera_info_topic, options.pose_topic, imu_topic)
        bag.select_topics([topics.image, topics.camera_info, topics.pose, *filter(None, [imu_topic])])
        camera = load_camera(bag, topics.camera_info)
        collector = BearingCollector(camera, light)
        total = bag.topics[topics.image].message_count
        images = drive_images(bag, topics, mount, camera)
        for image in tqdm(images, total=total, unit='image', delay=1.0, disable=None):
            collector.add(image.stamp, image.pixels, image.position, image.rotation)
    results = {beacon: survey_lamp(bearings, options.tilt_sigma) for beacon, bearings in collector.bearings().items()}
    for beacon, result in results.items():
        print(f'beacon {beacon:<5} {_describe(result)}')
    return results


def _describe(result: SurveyedLamp | NotSurveyed) -> str:
    if isinstance(result, NotSurveyed):
        return result.reason
    position = '  '.join(f'{x:.4f} +- {s:.4f}' for x, s in zip(result.xyz, result.sigma, strict=True))
    return f'{position} m from {result.observations} images'


def make_parser() -> argparse.ArgumentParser:
    """Return the command-line parser."""
    parser = argparse.ArgumentParser(
        prog='survey',
        description='Survey the positions of lamps that send their ID, from a bag of images and known poses. '
        'Drive past each lamp, in both directions if possible: this cancels errors of the camera mount.',
    )
    add = parser.add_argument
    add('bag', type=Path, help='rosbag2 with images, camera_info, poses and optionally an imu')
    add('--lamp-radius', type=float, required=True, help='radius of the bright disc [m], for the beacons file')
    add('--out', type=Path, default=Path('out/beacons.yaml'), metavar='FILE', help='default: %(default)s')
    add('--image-topic', default='/image_raw/compressed', metavar='TOPIC', help='default: %(default)s')
    add('--camera-info-topic', default='/camera_info', metavar='TOPIC', help='default: %(default)s')
    add(
        '--pose-topic',
        default='/ground_truth',
        metavar='TOPIC',
        help='pose of the base in the map (default: %(default)s)',
    )
    add('--imu-topic', metavar='TOPIC',
        help=f'IMU whose orientation gives the tilt (default: {_IMU_TOPIC} if the bag has it)')  # fmt: skip
    add_settings(parser, ReceiverSettings, _LIGHT_OPTIONS)
    add('--tilt-sigma', type=float, default=PoseSettings.tilt_sigma,
        help='standard deviation of the constant tilt error [rad] (default: %(default)s)')  # fmt: skip
    add_mount_options(parser, NodeSettings(), 'up, image top ahead')
    return parser


if __name__ == '__main__':
    sys.exit(main())
