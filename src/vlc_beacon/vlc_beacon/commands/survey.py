"""``survey``: beacon positions from a recorded drive with known poses."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ShirubeBagsError
from shirube_core.command import add_settings, run_command
from shirube_core.geometry import CameraMount
from shirube_core.settings import SettingsError, check_settings
from shirube_ros.errors import MessageError
from shirube_ros.offline.locate import add_mount_options
from vlc_beacon.core.pose.lamp_rays import Beacon
from vlc_beacon.core.settings import PoseSettings, ReceiverSettings
from vlc_beacon.core.survey.beacon_survey import NotSurveyed, SurveyedLamp, survey_lamp
from vlc_beacon.core.survey.bearing_collector import BearingCollector
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.files.beacons_file import RADIUS_RANGE, save_beacons
from vlc_beacon.files.survey_drive import DriveTopics, drive_images, load_camera
from vlc_beacon.node_settings import NodeSettings

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
