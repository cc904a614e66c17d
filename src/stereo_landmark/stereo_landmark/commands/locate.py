"""``locate``: localizes the robot at taught places from images or a bag, without ROS running."""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

from tqdm import tqdm

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import CameraMount
from shirube_core.settings import settings_from_values
from shirube_ros.camera.image import to_grey
from shirube_ros.errors import CameraFileError
from shirube_ros.offline.locate import OfflineLocalizer, add_common_options, locate_recording, run_command
from shirube_ros.offline.recording import RecordedImage, RecordingTopics
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Side
from stereo_landmark.core.pair.pair_stream import LocatedPair, PairStream
from stereo_landmark.core.settings import LandmarkSettings, PairSettings, PlaceSettings
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import (
    add_pair_options,
    choose_topics,
    load_grey_image,
    pair_files,
    pair_recording,
)
from stereo_landmark.files.displacement_files import LocatedFrame, save_displacements
from stereo_landmark.files.place_file import load_places
from stereo_landmark.node_settings import NodeSettings

_RATES = 1e-4, 1e6
"""Limits of the image rate [1/s]."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if a file is malformed or no pair has a displacement."""
    options = make_parser().parse_args(arguments)
    return run_command(lambda: save_and_report(locate(options), options.out), (StereoLandmarkError,), options.out)


def save_and_report(frames: Sequence[LocatedFrame], folder: Path) -> tuple[list[str], str]:
    """Write the results; return the report and a fault if no pair has a displacement."""
    files = save_displacements(folder, frames)
    places = Counter(frame.fix.place.name for frame in frames if frame.fix is not None)
    report = [f'{places.total()} of {len(frames)} pairs have a displacement; see {", ".join(map(str, files))}']
    report += [f'{number} at {name}' for name, number in places.most_common()]
    failures = Counter(frame.failure[0] for frame in frames if frame.fix is None).most_common()
    report += [f'{number} without: {failure}' for failure, number in failures]
    return report, '' if places else f'no pair has a displacement: {failures[0][0]}'


def locate(options: argparse.Namespace) -> list[LocatedFrame]:
    """Return the results of all pairs in their order.

    Raises:
        StereoLandmarkError: places, calibrations and images are inconsistent.
    """
    create = make_stream_factory(options)
    if options.bag is None:
        return list(tqdm(locate_files(options, create()), unit='pair', delay=1.0, disable=None))
    with BagReader(options.bag) as bag:
        topics = choose_topics(bag, vars(options), is_raw=options.rectify)
        total = bag.topics[topics.images[0]].message_count
        frames = locate_bag(bag, topics, create)
        located = list(tqdm(frames, total=total, unit='pair', delay=1.0, disable=None))
    if not located:
        raise StereoLandmarkError(
            f'{options.bag}: left and right images have no common stamps; give --approximate-sync'
        )
    return located


def locate_bag(
    bag: BagReader, topics: RecordingTopics, create_stream: Callable[[], PairStream]
) -> Iterator[LocatedFrame]:
    """Yield the pairs of an open bag with their results, located as in the node; see `locate_recording`."""

    def create() -> OfflineLocalizer[CameraCalibration, LocatedPair]:
        stream = create_stream()

        def locate(_: float, image: RecordedImage[CameraCalibration]) -> LocatedPair | None:
            side, pixels = Side(image.camera), to_grey(image.pixels)
            return stream.add_image(side, image.stamp_ns, pixels, image.calibration)

        return OfflineLocalizer(locate, add_tilt=stream.add_tilt)

    results = locate_recording(pair_recording(bag, topics), create, (StereoLandmarkError,))
    for topic, stamp_ns, result in results:
        if isinstance(result, str):
            yield LocatedFrame(topic, stamp_ns, result)
        else:
            yield LocatedFrame(topics.images[Side.LEFT], result.stamp_ns, result)


def locate_files(options: argparse.Namespace, stream: PairStream) -> Iterator[LocatedFrame]:
    """Yield the results of pairs of files.

    Raises:
        StereoLandmarkError: the files are not given in pairs, or the calibrations are not those of the places.
        CameraFileError: a calibration is malformed, or an image does not exist.
    """
    files, (left, right) = pair_files(options)
    if not _RATES[0] < options.rate < _RATES[1]:
        raise StereoLandmarkError(
            f'--rate must be above {_RATES[0]:g} and below {_RATES[1]:g}; give the pairs per second'
        )
    stream.get_localizer(left, right)
    for number, paths in enumerate(files):
        stamp_ns = round(number / options.rate * 1e9)
        stream.add_tilt(stamp_ns * 1e-9, *options.tilt)
        located = _locate_pair(stream, stamp_ns, paths, (left, right))
        if located is not None:
            yield LocatedFrame(str(paths[0]), stamp_ns, located)


def _locate_pair(
    stream: PairStream,
    stamp_ns: int,
    paths: tuple[Path, Path],
    calibrations: tuple[CameraCalibration, CameraCalibration],
) -> LocatedPair | str | None:
    """Return the result of a pair of files, or an error message; an unreadable pair does not stop the run."""
    try:
        # Both are read first, so that an image whose partner is corrupted does not stay in the queue.
        images = [load_grey_image(path) for path in paths]
        answers = [stream.add_image(side, stamp_ns, images[side], calibrations[side]) for side in Side]
    except (StereoLandmarkError, CameraFileError) as fault:
        return str(fault)
    return answers[Side.RIGHT]


def make_stream_factory(options: argparse.Namespace) -> Callable[[], PairStream]:
    """Return a factory for the stateful stream of pairs.

    Raises:
        StereoLandmarkError: a taught place is malformed.
    """
    tolerance = options.approximate_sync
    pairing = settings_from_values(
        PairSettings,
        {
            'rectify': options.rectify,
            'approximate_sync': tolerance is not None,
            'approximate_sync_tolerance_seconds': tolerance or 0.0,
        },
    )
    method = settings_from_values(LandmarkSettings, {'place.method': options.method, 'mode': options.mode})
    mount = CameraMount(tuple(options.camera_xyz), tuple(options.camera_rpy))
    return partial(PairStream, load_places(options.places), mount, pairing, method)


def make_parser() -> argparse.ArgumentParser:
    """Return the argument parser."""
    parser = argparse.ArgumentParser(
        prog='locate',
        description='Localize the robot at taught places from stereo images or a bag. Writes poses.csv with a pose '
        'or a failure reason per pair, displacements_<place>.tum in the frame of each place, and poses.tum in the '
        'map for places with a map pose.',
    )
    add = parser.add_argument
    add('--places', type=Path, required=True, metavar='FOLDER', help='folder of the taught places')
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument('--left', type=Path, nargs='+', help='folder of left images, or left images in order')
    source.add_argument('--bag', type=Path, help='rosbag2 with images, camera_info and optional imu')
    add('--rate', type=float, default=10.0, help='image rate of folders [1/s] (default: %(default)s)')
    add_common_options(parser, (), NodeSettings(), 'looking ahead')
    add_pair_options(parser)
    add('--mode', default=LandmarkSettings.mode,
        help="likelihood, or paper: the paper's search and closed form (default: %(default)s)")  # fmt: skip
    add('--method', default=PlaceSettings.method,
        help='estimation method: reprojection or closed_form (default: %(default)s)')  # fmt: skip
    return parser


if __name__ == '__main__':
    sys.exit(main())
