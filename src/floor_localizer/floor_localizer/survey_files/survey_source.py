"""Images of a survey with their odometry: a folder with a pose file, or a bag."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.odometry_buffer import OdometryBuffer
from floor_localizer.survey_files.image_batches import BagImageBatch, FileImageBatch, ImageBatch
from floor_localizer.survey_files.odometry_file import load_odometry
from shirube_bags.bag_reader import BagReader
from shirube_core.geometry import SE2, PinholeCamera
from shirube_ros.camera.files import list_images, load_calibration
from shirube_ros.camera.info import camera_from_camera_info
from shirube_ros.errors import MessageError
from shirube_ros.offline.recording import RecordedOdometry, Recording, RecordingTopics, choose_topics

_NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Frame:
    """Reference to an image that is not read yet.

    Attributes:
        name: human-readable name.
        T_odom_base: pose of the robot by odometry.
    """

    name: str
    T_odom_base: SE2


class SurveySource(Protocol):
    """Images in order.

    Attributes:
        frames: all images.
        camera: camera that took them.
    """

    frames: list[Frame]
    camera: PinholeCamera

    def batch(self, wanted: Sequence[int]) -> ImageBatch:
        """Return the images of ascending indices as a batch that any process can read."""
        ...


class FolderSource:
    """Images in a folder.

    Attributes:
        files: paths of the images.
        frames: all images.
        camera: camera that took them.
    """

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
    """The images of a bag, with its odometry and camera_info.

    Attributes:
        files: files of the bag.
        frames: all images.
        camera: camera that took them.
    """

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
            Frame(
                f'image {index} of {self._topics.images[0]}', odometry_buffer.pose_at(stamp, f'image {index}')
            )
            for index, stamp in enumerate(stamps)
        ]

    def batch(self, wanted: Sequence[int]) -> BagImageBatch:
        """Return the images of ascending indices as a batch that any process can read."""
        begin, end = self._received[wanted[0]], self._received[wanted[-1]]
        first = bisect_left(self._received, begin)
        return BagImageBatch(
            self._path.absolute(), self._topics.images[0], begin, end, first, tuple(wanted), self.camera
        )


def _read_odometry(bag: BagReader, topic: str) -> OdometryBuffer:
    stamps, poses = [], []
    for message in Recording(bag, RecordingTopics((), (), topic), camera_from_camera_info).messages():
        if isinstance(message, RecordedOdometry):
            stamp = message.header.stamp
            stamps.append(stamp.sec * _NANOSECONDS + stamp.nanosec)
            poses.append((message.T_odom_base.x, message.T_odom_base.y, message.T_odom_base.yaw))
    return OdometryBuffer(np.array(stamps, dtype=np.int64), np.array(poses).reshape(-1, 3), topic)


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
