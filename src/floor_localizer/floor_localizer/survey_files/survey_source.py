"""Images of a survey with their odometry: a folder with a pose file (CSV or TUM), or a bag."""

import csv
import math
from bisect import bisect_left
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.errors import FloorLocalizerError
from floor_localizer.survey_files.survey_images import BagImageBatch, FileImageBatch, Frame, ImageBatch
from shirube_bags.bag_reader import BagReader
from shirube_bags.trajectory_files import load_tum
from shirube_core.geometry import SE2, PinholeCamera, yaw_from_quaternion
from shirube_core.motion import NoPoseReason, OdometryBuffer
from shirube_ros.camera.files import list_images, load_calibration
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.errors import MessageError
from shirube_ros.offline.recording import RecordedOdometry, Recording, RecordingTopics, choose_topics


class SurveyOdometry:
    """Odometry in order of time."""

    def __init__(self, stamps_ns: NDArray[np.int64], poses: NDArray[np.float64], source: str) -> None:
        """Check and store the odometry.

        Args:
            stamps_ns: stamps, shape (n,) [ns].
            poses: x, y [m] and yaw [rad], shape (n, 3).
            source: topic or file, for error messages.

        Raises:
            FloorLocalizerError: there is no odometry, or its stamps do not increase.
        """
        if len(stamps_ns) < 2:
            raise FloorLocalizerError(
                f'{source}: contains no odometry; a survey needs it from the first to the last image'
            )
        back = np.flatnonzero(np.diff(stamps_ns) <= 0)
        if len(back):
            at = 1e-9 * (stamps_ns[back[0]] - stamps_ns[0])
            raise FloorLocalizerError(
                f'{source}: its stamps run backwards {at:.3f} s after the first; record the drive in one go'
            )
        self._start, self._source = int(stamps_ns[0]), source
        self._buffer = OdometryBuffer(history=2**63)  # all of it
        for stamp, pose in zip(stamps_ns.tolist(), poses.tolist(), strict=True):
            self._buffer.add(stamp, SE2(*pose))

    def pose_at(self, stamp_ns: int, name: str) -> SE2:
        """Return ``T_odom_base`` at a stamp; the FloorLocalizerError without odometry there has the image's name."""
        pose = self._buffer.pose_at(stamp_ns)
        if isinstance(pose, NoPoseReason):
            time = 1e-9 * (stamp_ns - self._start)
            raise FloorLocalizerError(
                f'{self._source}: odometry is missing around {name} ({time:.3f} s after the first); '
                'a survey needs it from the first to the last image'
            )
        return pose


COLUMNS = ('image', 'x', 'y', 'yaw')
_NANOSECONDS = 1_000_000_000


def load_odometry(path: Path, images: Sequence[Path]) -> list[SE2]:
    """Return ``T_odom_base`` of each image.

    Args:
        path: CSV with the header ``image,x,y,yaw`` (metres, radians), or a TUM file, which has no header and is
            named ``*.tum`` or ``*.txt``.
        images: paths of the images, in order.

    Raises:
        FloorLocalizerError: the file is malformed or images are missing in it.
        TumFileError: the TUM file is malformed.
    """
    if path.suffix.lower() != '.csv':
        return _from_tum(path, len(images))
    known = _from_csv(path)
    for image in images:
        if image.name not in known:
            raise FloorLocalizerError(f'{path}: odometry is missing for {image.name}; give one line per image')
    return [known[image.name] for image in images]


def _from_tum(path: Path, count: int) -> list[SE2]:
    trajectory = load_tum(path)
    lines = [line for line in path.read_text().splitlines() if line.strip() and not line.lstrip().startswith('#')]
    stamps = [float(line.split()[0]) for line in lines]
    back = np.flatnonzero(np.diff(stamps) <= 0.0)
    if len(back):
        raise FloorLocalizerError(
            f'{path}: its stamps run backwards after {stamps[back[0]]:.3f} s; give the poses in the order of the images'
        )
    if len(trajectory) != count:
        raise FloorLocalizerError(f'{path}: has {len(trajectory)} poses for {count} images; give one line per image')
    return [
        SE2(float(xyz[0]), float(xyz[1]), yaw_from_quaternion(*(float(batch) for batch in q)))
        for xyz, q in zip(trajectory.positions, trajectory.quaternions, strict=True)
    ]


def _from_csv(path: Path) -> dict[str, SE2]:
    try:
        rows = list(csv.reader(path.read_text(encoding='utf-8-sig').splitlines()))
    except (OSError, UnicodeDecodeError) as fault:
        raise FloorLocalizerError(
            f'{path}: cannot be read; give a CSV with the header "{",".join(COLUMNS)}"'
        ) from fault
    if not rows or tuple(field.strip().lower() for field in rows[0]) != COLUMNS:
        raise FloorLocalizerError(f'{path}, line 1: the header must be "{",".join(COLUMNS)}" (metres and radians)')
    known: dict[str, SE2] = {}
    for number, row in enumerate(rows[1:], start=2):
        if not row:
            continue
        try:
            name, *numbers = row
            x, y, yaw = (float(field) for field in numbers)
        except ValueError as fault:
            raise FloorLocalizerError(
                f'{path}, line {number}: is not a name and three numbers; write "{",".join(COLUMNS)}"'
            ) from fault
        if not all(math.isfinite(value) for value in (x, y, yaw)):
            raise FloorLocalizerError(f'{path}, line {number}: is not finite; give metres and radians')
        if name.strip() in known:
            raise FloorLocalizerError(f'{path}, line {number}: {name} is a duplicate; keep one')
        known[name.strip()] = SE2(x, y, yaw)
    return known


class SurveySource(Protocol):
    """Images in order, and the camera that took them; ``batch`` takes ascending indices."""

    frames: list[Frame]
    camera: PinholeCamera

    def batch(self, wanted: Sequence[int]) -> ImageBatch: ...  # noqa: D102


class FolderSource:
    """Images in a folder, with the poses of a file, and the camera that took them."""

    def __init__(self, folder: Path, calibration: Path, odometry: Path) -> None:
        """Read the poses of all images.

        Raises:
            FloorLocalizerError: odometry is missing or malformed.
            CameraFileError: the folder or the calibration cannot be read.
        """
        self.camera = load_calibration(calibration)
        self.files = list_images([folder])
        poses = load_odometry(odometry, self.files)
        self.frames = [Frame(path.name, pose) for path, pose in zip(self.files, poses, strict=True)]

    def batch(self, wanted: Sequence[int]) -> FileImageBatch:
        """Return the images of ascending indices as a batch that any process can read."""
        return FileImageBatch(tuple((index, self.files[index].absolute()) for index in wanted), self.camera)


class BagSource:
    """The images of a bag, with its odometry and camera_info."""

    def __init__(self, path: Path, image: str | None, camera_info: str | None, odometry: str | None) -> None:
        """Read all stamps and poses.

        Raises:
            FloorLocalizerError: odometry is missing or its stamps run backwards, or there is no usable camera_info.
            BagError: the bag or a topic is missing.
        """
        self._path = path
        self.files = sorted(each for each in path.iterdir() if each.is_file()) if path.is_dir() else [path]
        with BagReader(path) as bag:
            self._topics = choose_topics(bag, image, camera_info, odometry)
            if not self._topics.odometry:
                raise FloorLocalizerError(
                    f'{path}: has no odometry; record nav_msgs/msg/Odometry along with the images'
                )
            odometry_buffer = _read_odometry(bag, self._topics.odometry)
            self.camera, stamps, self._received = _read_stamps(bag, self._topics)
        self.frames = [
            Frame(f'image {index} of {self._topics.images[0]}', odometry_buffer.pose_at(stamp, f'image {index}'))
            for index, stamp in enumerate(stamps)
        ]

    def batch(self, wanted: Sequence[int]) -> BagImageBatch:
        """Return the images of ascending indices as a batch that any process can read."""
        begin, end = self._received[wanted[0]], self._received[wanted[-1]]
        first = bisect_left(self._received, begin)
        return BagImageBatch(
            self._path.absolute(), self._topics.images[0], begin, end, first, tuple(wanted), self.camera
        )


def _read_odometry(bag: BagReader, topic: str) -> SurveyOdometry:
    stamps, poses = [], []
    for message in Recording(bag, RecordingTopics((), (), topic), camera_from_camera_info).messages():
        if isinstance(message, RecordedOdometry):
            stamp = message.header.stamp
            stamps.append(stamp.sec * _NANOSECONDS + stamp.nanosec)
            poses.append((message.T_odom_base.x, message.T_odom_base.y, message.T_odom_base.yaw))
    return SurveyOdometry(np.array(stamps, dtype=np.int64), np.array(poses).reshape(-1, 3), topic)


def _read_stamps(bag: BagReader, topics: RecordingTopics) -> tuple[PinholeCamera, list[int], list[int]]:
    """Return the first usable calibration, and the stamp and receive time of each image [ns]."""
    camera, taken, received = None, [], []
    image, camera_info = topics.images[0], topics.camera_infos[0]
    for raw in bag.messages([image, camera_info]):
        if raw.topic == image:
            stamp = bag.decode(raw).header.stamp
            taken.append(stamp.sec * _NANOSECONDS + stamp.nanosec)
            received.append(raw.stamp_ns)
        elif camera is None:
            with suppress(MessageError):  # a later message may be valid
                camera = camera_from_camera_info(bag.decode(raw), camera_info)
    if camera is None:
        raise FloorLocalizerError(f'{image}: has no valid calibration; record camera_info as well')
    return camera, taken, received
