"""``locate``: computes poses from a dot map and images or a bag, without ROS running."""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import starmap
from pathlib import Path

import numpy as np
from tqdm import tqdm

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.core.localizer import FloorLocalizer
from floor_localizer.core.settings import LocalizerSettings
from floor_localizer.core.tracker import FloorTracker
from floor_localizer.localization.localizer_from_map_file import STARTUP_NOTICE, NodeSettings, localizer_from_map_file
from shirube_bags.bag_reader import BagReader
from shirube_bags.stamps import text_from_stamp
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

COLUMNS = (
    *('image', 'stamp', 'x', 'y', 'yaw', 'sigma_x', 'sigma_y', 'sigma_yaw'),
    *('dots', 'matched', 'scale', 'roll', 'pitch', 'expected_chance_alignments', 'reason', 'detail', 'level'),
)


@dataclass(frozen=True)
class LocatedImage:
    """Name and time [ns] (files: index in seconds) of an image, and its pose, or why it has none."""

    name: str
    stamp_ns: int
    result: Fix | NoFix | str

    @property
    def failure(self) -> str:
        """Reason for no pose, empty if there is one."""
        if isinstance(self.result, Fix):
            return ''
        return self.result if isinstance(self.result, str) else self.result.reason.value


def save_pose_table(path: Path, images: Sequence[LocatedImage]) -> None:
    """Write one line per image, in metres and radians, atomically; raises `OSError`."""
    rows = ([image.name, text_from_stamp(image.stamp_ns), *_fields(image)] for image in images)
    write_csv(path, COLUMNS, rows)


def _fields(image: LocatedImage) -> list[str]:
    result = image.result
    if isinstance(result, Fix):
        pose, sigmas = result.T_map_base, np.sqrt(np.diag(result.covariance))
        numbers = [
            *(f'{pose.x:.7f}', f'{pose.y:.7f}', f'{pose.yaw:.7f}'),
            *(f'{sigma:.7f}' for sigma in sigmas),
            *(str(len(result.dots)), str(int(result.matched.sum()))),
            *(f'{result.scale:.6f}', f'{result.tilt[0]:.6f}', f'{result.tilt[1]:.6f}'),
            f'{result.expected_chance_alignments:.3g}',
        ]
        return [*numbers, '', '', result.level]
    dots = str(len(result.dots)) if isinstance(result, NoFix) and result.dots is not None else ''
    detail = result.detail if isinstance(result, NoFix) else ''
    return [*[''] * 6, dots, *[''] * 5, image.failure, detail, '']


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 for an invalid file or if no image has a pose."""
    options = make_parser().parse_args(arguments)
    return run_command(lambda: save_and_report(locate(options), options.out), (FloorLocalizerError,), options.out)


def save_and_report(images: Sequence[LocatedImage], folder: Path) -> tuple[list[str], str]:
    """Write the results; return the report and a fault if no image has a pose."""
    save_pose_table(folder / 'poses.csv', images)
    poses = {image.stamp_ns: image.result.T_map_base for image in images if isinstance(image.result, Fix)}
    fixes = save_poses(folder / 'poses.tum', poses)
    report = [f'{fixes} of {len(images)} images have a pose; see {folder / "poses.csv"}']
    failures = Counter(image.failure for image in images if image.failure).most_common()
    report += [f'{number} without a pose: {failure}' for failure, number in failures]
    return report, '' if fixes else 'no image has a pose; check map, calibration and camera_xyz'


def locate(options: argparse.Namespace) -> list[LocatedImage]:
    """Return the results of all images, in order: with tracking in a bag, else each image independently."""
    settings = NodeSettings(
        map_file=str(options.map), camera_xyz=tuple(options.camera_xyz), camera_rpy=tuple(options.camera_rpy)
    )
    check_settings(settings)

    def load_localizer() -> FloorLocalizer:
        print(STARTUP_NOTICE, file=sys.stderr)
        matching = LocalizerSettings(matcher=options.matcher)
        return localizer_from_map_file(settings, matching, partial(print, file=sys.stderr))

    if options.bag is None:

        def create() -> Callable[..., Fix | NoFix]:
            localizer = load_localizer()
            return lambda _, pixels, camera: localizer.locate(pixels, camera)

        return list(starmap(LocatedImage, locate_files(options, create)))
    with BagReader(options.bag) as bag:
        topics = choose_topics(bag, options.topic, options.camera_info_topic, options.odom_topic)
        images = locate_bag(bag, topics, partial(FloorTracker, load_localizer(), settings.tracker))
        total = bag.topics[topics.images[0]].message_count
        return list(tqdm(images, total=total, unit='image', disable=None))


def locate_bag(
    bag: BagReader, topics: RecordingTopics, create_tracker: Callable[[], FloorTracker]
) -> Iterator[LocatedImage]:
    """Yield the images of an open bag with their results, located as in the node; see `locate_recording`."""

    def create() -> OfflineLocalizer[PinholeCamera, Fix | NoFix]:
        tracker = create_tracker()
        return OfflineLocalizer(
            lambda stamp, image: tracker.track(stamp, image.pixels, image.calibration), tracker.add_odometry
        )

    recording = Recording(bag, topics, camera_from_camera_info)
    return starmap(LocatedImage, locate_recording(recording, create, (FloorLocalizerError,)))


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='locate',
        description='Compute the poses of images on a dot map: single images independently, a bag with tracking as in '
        'the node. Writes poses.tum, and poses.csv with the reason for each image without a pose.',
    )
    parser.add_argument('--map', type=Path, required=True, help='dot map, CSV or .dotmap')
    add_single_camera_options(parser, 'perhaps odom')
    parser.add_argument(
        '--matcher',
        choices=('constellation', 'pole_star'),
        default='constellation',
        help="search of the whole map: the default, or the paper's pole star (default: %(default)s)",
    )
    topics = ('topic', 'camera-info-topic', 'odom-topic')
    add_common_options(parser, topics, NodeSettings(), 'looking down')
    return parser


if __name__ == '__main__':
    sys.exit(main())
