"""``locate``: poses from a beacons file and images or a bag, without ROS running."""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import starmap
from pathlib import Path

import numpy as np
from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_bags.stamps import text_from_stamp
from shirube_core.command import add_settings
from shirube_core.files import write_csv
from shirube_core.geometry import PinholeCamera
from shirube_core.settings import check_settings
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.offline.locate import (
    OfflineLocalizer,
    add_common_options,
    add_single_camera_options,
    locate_files,
    locate_recording,
    run_command,
    save_poses,
)
from shirube_ros.offline.recording import Recording, RecordingTopics, choose_topics
from vlc_beacon.core.pose.pose_fix import BeaconFix
from vlc_beacon.core.receiver.beacon_receiver import BeaconReceiver, ReceiverOutput
from vlc_beacon.core.settings import AuthorizationSettings, ReceiverSettings
from vlc_beacon.core.vlc_beacon_error import VlcBeaconError
from vlc_beacon.node_settings import NodeSettings, authorizer_from_settings, beacons_from_settings


@dataclass(frozen=True)
class LocatedImage:
    """The image of a file or topic at a stamp [ns], and the receiver output or the error message."""

    name: str
    stamp_ns: int
    result: ReceiverOutput | str

    @property
    def fix(self) -> BeaconFix | None:
        """The pose, None if there is none."""
        if isinstance(self.result, ReceiverOutput) and isinstance(self.result.result, BeaconFix):
            return self.result.result
        return None

    @property
    def failure(self) -> str:
        """Reason for no pose, empty if there is one."""
        if isinstance(self.result, str):
            return self.result
        return '' if isinstance(self.result.result, BeaconFix) else self.result.result.reason.value


_POSE = ('x', 'y', 'z', 'yaw', 'sigma_x', 'sigma_y', 'sigma_z', 'sigma_yaw')
COLUMNS = ('image', 'stamp', *_POSE, 'lamps', 'beacons', 'used', 'anomalies', 'reason', 'detail')


def save_pose_table(path: Path, images: Sequence[LocatedImage]) -> None:
    """Write one line per image, in metres and radians, atomically; raises `OSError`."""
    rows = ([image.name, text_from_stamp(image.stamp_ns), *_fields(image)] for image in images)
    write_csv(path, COLUMNS, rows)


def save_messages(path: Path, images: Sequence[LocatedImage]) -> int:
    """Write one line per message of a lamp, atomically; return their number; raises `OSError`."""
    rows = [
        [text_from_stamp(image.stamp_ns), '' if m.sender is None else str(m.sender), m.to_json()]
        for image in images
        if isinstance(image.result, ReceiverOutput)
        for m in image.result.messages
    ]
    write_csv(path, ('stamp', 'beacon', 'data'), rows)
    return len(rows)


def _fields(image: LocatedImage) -> list[str]:
    if not isinstance(image.result, ReceiverOutput):
        return [*[''] * (len(_POSE) + 4), image.failure, '']
    lamps, fix = image.result.lamps, image.fix
    names = ' '.join(str(name) for name in sorted(lamp.beacon for lamp in lamps if lamp.beacon is not None))
    anomalies = ' '.join(f'{anomaly.id}:{anomaly.kind.value}' for anomaly in image.result.result.anomalies)
    if fix is None:
        detail = getattr(image.result.result, 'detail', '')
        return [*[''] * len(_POSE), str(len(lamps)), names, '', anomalies, image.failure, detail]
    pose, sigmas = fix.T_map_base, np.sqrt(np.diag(fix.covariance))
    numbers = (pose.x, pose.y, fix.height, pose.yaw, *sigmas.tolist())
    poses = [f'{number:.6f}' for number in numbers]
    return [*poses, str(len(lamps)), names, str(int(fix.used.sum())), anomalies, '', '']


_LIGHT_OPTIONS = (
    *('shutter', 'row_time', 'exposure_time', 'lamp_frame_rate'),
    *('segment_bytes', 'blooming', 'method', 'camera_height_known'),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when a file is invalid or no image gave a pose."""
    options = make_parser().parse_args(arguments)
    return run_command(lambda: save_and_report(locate(options), options.out), (VlcBeaconError,), options.out)


def save_and_report(images: Sequence[LocatedImage], folder: Path) -> tuple[list[str], str]:
    """Write the results; return the report and a fault if no image gave a pose."""
    save_pose_table(folder / 'poses.csv', images)
    poses = {image.stamp_ns: image.fix.T_map_base for image in images if image.fix is not None}
    fixes = save_poses(folder / 'poses.tum', poses)
    report = [f'{fixes} of {len(images)} images have a pose; see {folder / "poses.csv"}']
    if messages := save_messages(folder / 'data.csv', images):
        report.append(f'{messages} messages of lamps; see {folder / "data.csv"}')
    failures = Counter(image.failure for image in images if image.failure).most_common()
    report += [f'{number} without a pose: {failure}' for failure, number in failures]
    return report, '' if fixes else 'no image gave a pose; check beacons, shutter, exposure time and camera'


def locate(options: argparse.Namespace) -> list[LocatedImage]:
    """Return the results of all images, in order, located as in the node."""
    if options.bag is None:
        images = locate_files(options, lambda: create_receiver(options).receive, options.rate)
        return list(starmap(LocatedImage, images))
    with BagReader(options.bag) as bag:
        names = (options.topic, options.camera_info_topic, options.odom_topic, options.imu_topic)
        topics = choose_topics(bag, *names)
        total = bag.topics[topics.images[0]].message_count
        results = locate_bag(bag, topics, lambda: create_receiver(options))
        return list(tqdm(results, total=total, unit='image', disable=None))


def locate_bag(
    bag: BagReader, topics: RecordingTopics, create_receiver: Callable[[], BeaconReceiver]
) -> Iterator[LocatedImage]:
    """Yield the images of an open bag with their results, located as in the node; see `locate_recording`."""

    def create() -> OfflineLocalizer[PinholeCamera, ReceiverOutput]:
        receiver = create_receiver()
        return OfflineLocalizer(
            lambda stamp, image: receiver.receive(stamp, image.pixels, image.calibration),
            receiver.add_odometry,
            receiver.add_tilt,
        )

    recording = Recording(bag, topics, camera_from_camera_info)
    return starmap(LocatedImage, locate_recording(recording, create, (VlcBeaconError,)))


def create_receiver(options: argparse.Namespace) -> BeaconReceiver:
    """Return a new receiver for poses only; it has no key, so it rejects all commands."""
    node = NodeSettings(
        beacons_file=str(options.beacons), camera_xyz=tuple(options.camera_xyz), camera_rpy=tuple(options.camera_rpy)
    )
    light = ReceiverSettings(**{name: getattr(options, name) for name in _LIGHT_OPTIONS})
    check_settings(node)
    check_settings(light)
    beacons = beacons_from_settings(node)
    return BeaconReceiver(beacons, node.mount, authorizer_from_settings(node, AuthorizationSettings(), beacons), light)


def make_parser() -> argparse.ArgumentParser:
    """Return the command-line parser."""
    parser = argparse.ArgumentParser(
        prog='locate',
        description='Compute the poses of an image sequence under beacons, given as images or a bag. '
        'Writes poses.tum, poses.csv with the failure reason of images without a pose, and data.csv with the '
        'messages of the lamps.',
    )
    add = parser.add_argument
    add('--beacons', type=Path, required=True, metavar='YAML', help='beacons file: lamps and their positions')
    add_single_camera_options(parser, 'optional odom and imu')
    add('--rate', type=float, default=60.0, help='frame rate of a folder of images [1/s] (default: %(default)s)')
    topics = ('topic', 'camera-info-topic', 'odom-topic', 'imu-topic')
    add_common_options(parser, topics, NodeSettings(), 'looking up')
    add_settings(parser, ReceiverSettings, _LIGHT_OPTIONS)
    return parser


if __name__ == '__main__':
    sys.exit(main())
