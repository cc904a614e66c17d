"""Grey images, camera calibrations and recorded stereo pairs."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import TiltBuffer
from shirube_ros.camera.files import list_images, load_camera_info, load_image
from shirube_ros.camera.image import to_grey
from shirube_ros.camera.info import camera_from_camera_info, projection_from_camera_info
from shirube_ros.errors import CalibrationError, CameraInfoError
from shirube_ros.offline.recording import (
    RecordedImage,
    RecordedTilt,
    Recording,
    RecordingTopics,
    choose_camera_info,
    choose_images,
    choose_imu,
)
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Side, StampSynchronizer
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def load_grey_image(path: Path) -> NDArray[np.uint8]:
    """Load an image as grey, shape (h, w).

    Raises:
        ImageFileError: the file is not an image, or is truncated.
    """
    return to_grey(load_image(path))


def encode_png(image: NDArray[np.uint8]) -> bytes:
    """Encode a grey image, shape (h, w), as PNG."""
    _, data = cv2.imencode('.png', image)
    return data.tobytes()


def add_pair_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of stereo pairs besides ``--left`` and ``--bag``."""
    add: Callable[..., Any] = parser.add_argument
    add('--right', type=Path, nargs='+', help='right images in the same order')
    for side in ('left', 'right'):
        add(f'--{side}-calibration', type=Path, metavar='YAML',
            help=f'calibration of the {side} camera, as camera_calibration writes it')  # fmt: skip
    for name in ('left-image', 'left-camera-info', 'right-image', 'right-camera-info', 'imu'):
        add(f'--{name}', metavar='TOPIC', help='topic of the bag (default: the usual or the only one)')
    add('--tilt', type=float, nargs=2, default=(0.0, 0.0), metavar=('ROLL', 'PITCH'),
        help='roll and pitch of the robot, without imu [rad] (default: level)')  # fmt: skip
    add('--rectify', action='store_true', help='rectify raw images')
    add('--approximate-sync', type=float, metavar='SECONDS',
        help='maximum stamp difference of a pair (default: equal stamps)')  # fmt: skip


def pair_files(options: argparse.Namespace) -> tuple[list[tuple[Path, Path]], tuple[CameraCalibration, ...]]:
    """Return the pairs of image files in the options, and the calibrations of the left and the right camera.

    Raises:
        StereoLandmarkError: the files are not given in pairs.
        CameraFileError: a calibration is malformed, or an image does not exist.
    """
    if not (options.right and options.left_calibration and options.right_calibration):
        raise StereoLandmarkError('--left needs --right, --left-calibration and --right-calibration')
    left, right = list_images(options.left), list_images(options.right)
    if len(left) != len(right):
        raise StereoLandmarkError(
            f'there are {len(left)} left and {len(right)} right images; give pairs in the same order'
        )
    paths = options.left_calibration, options.right_calibration
    return list(zip(left, right, strict=True)), tuple(map(load_camera_calibration, paths))


def load_camera_calibration(path: Path) -> CameraCalibration:
    """Load the calibration of one camera; raise a CalibrationError unless it is that of a camera of a stereo pair."""
    try:
        return calibration_from_camera_info(load_camera_info(path), str(path))
    except CameraInfoError as fault:
        raise CalibrationError(str(fault)) from fault


def calibration_from_camera_info(message: Any, topic: str) -> CameraCalibration:
    """Return the calibration of the raw and the rectified image.

    Raises:
        CameraInfoError: the camera is not calibrated, or not as part of a stereo pair.
    """
    camera = camera_from_camera_info(message, topic)
    rotation = tuple(float(number) for number in message.r)
    projection = tuple(map(float, projection_from_camera_info(message, topic).ravel()))
    try:
        return CameraCalibration(camera, rotation, projection)
    except StereoLandmarkError as fault:
        raise CameraInfoError(f'{topic}: {fault}') from fault


def choose_topics(bag: BagReader, requested: dict[str, Any], *, is_raw: bool) -> RecordingTopics:
    """Return the topics to use, left camera first: the requested ones, otherwise the default ones.

    Args:
        bag: open bag.
        requested: topic names by ``left_image``, ``left_camera_info``, ``right_image``, ``right_camera_info``, ``imu``.
        is_raw: whether to prefer raw images if the bag has both.

    Raises:
        BagError: a requested topic is missing or has another type, or the choice is empty or ambiguous.
    """
    images, camera_infos = [], []
    image_names = ('image_raw', 'image_rect') if is_raw else ('image_rect', 'image_raw')
    for side in ('left', 'right'):
        usual = tuple(f'/{side}/{name}{end}' for name in image_names for end in ('', '/compressed'))
        images.append(choose_images(bag, requested.get(f'{side}_image'), usual))
        name = requested.get(f'{side}_camera_info')
        camera_infos.append(choose_camera_info(bag, name, f'/{side}/camera_info'))
    return RecordingTopics(tuple(images), tuple(camera_infos), imu=choose_imu(bag, requested.get('imu')))


def pair_recording(bag: BagReader, topics: RecordingTopics) -> Recording[CameraCalibration]:
    """Return the messages of a bag with stereo calibrations; images may be raw."""
    return Recording(bag, topics, calibration_from_camera_info)


_QUEUE_SIZE = 10
"""Queue size per camera for synchronization."""

_Image = RecordedImage[CameraCalibration]


@dataclass(frozen=True)
class RecordedPair:
    """A stereo pair of a bag, raw or rectified.

    Attributes:
        left: image of the left camera.
        right: image of the right camera.
        tilt: roll and pitch of the base by the nearest IMU reading [rad], None without one.
    """

    left: _Image
    right: _Image
    tilt: tuple[float, float] | None


def recorded_pairs(
    bag: BagReader, topics: RecordingTopics, tolerance: float, begin_ns: int | None = None
) -> Iterator[RecordedPair]:
    """Yield the stereo pairs of a bag; unpaired images are skipped, as the cameras may start at different times.

    Args:
        bag: open bag.
        topics: topics of the bag to use.
        tolerance: largest stamp difference of a pair [s].
        begin_ns: stamp of the first image to use [ns]; None for all images.

    Raises:
        BagError: the bag is corrupted.
    """
    synchronizer: StampSynchronizer[_Image] = StampSynchronizer(round(tolerance * 1e9), _QUEUE_SIZE)
    tilts = TiltBuffer()
    pending: tuple[_Image, _Image] | None = None
    for message in pair_recording(bag, topics).messages():
        if isinstance(message, RecordedTilt):
            tilts.add(message.stamp_ns * 1e-9, *message.tilt)
            if pending is not None and message.stamp_ns >= pending[0].stamp_ns:
                yield _attach_tilt(pending, tilts)
                pending = None
        elif isinstance(message, RecordedImage) and (begin_ns is None or message.stamp_ns >= begin_ns):
            pair = None
            with suppress(StereoLandmarkError):  # the caller reports a bag without pairs
                pair = synchronizer.add(Side(message.camera), message.stamp_ns, message)
            if pair is None:
                continue
            if pending is not None:
                yield _attach_tilt(pending, tilts)
            # Wait for the next IMU reading, which may be nearer than the previous one.
            pending = pair
    if pending is not None:
        yield _attach_tilt(pending, tilts)


def _attach_tilt(pair: tuple[_Image, _Image], tilts: TiltBuffer) -> RecordedPair:
    return RecordedPair(*pair, tilts.tilt_at(pair[0].stamp_ns * 1e-9))
