"""The images of a survey with their odometry: a folder with a file of poses, or a bag."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from floor_localizer.bag_localization import choose_topics
from floor_localizer.core.floor_localizer_error import FloorLocalizerError
from floor_localizer.core.survey.odometry_trail import OdometryTrail
from floor_localizer.survey_files.odometry_file import load_odometry
from shirube_bags.bag_reader import BagReader
from shirube_geometry import PinholeCamera, PlanarPose
from shirube_recordings.recording import BadImage, RecordedImage, RecordedOdometry, Recording
from shirube_recordings.recording_topics import RecordingTopics
from shirube_ros.calibration_file import load_calibration
from shirube_ros.camera_info_conversion import camera_from_camera_info
from shirube_ros.file_errors import ImageFileError
from shirube_ros.image_files import list_images, load_image

Pixels = NDArray[np.uint8]


@dataclass(frozen=True)
class Frame:
    """An image before it is read.

    Attributes:
        name: for people.
        T_odom_base: where odometry puts the robot.
    """

    name: str
    T_odom_base: PlanarPose


class SurveySource(Protocol):
    """Images in their order.

    Attributes:
        frames: all of them.
        camera: that took them.
    """

    frames: list[Frame]
    camera: PinholeCamera

    def read(self, wanted: Sequence[int]) -> Iterator[tuple[int, Pixels | str]]:
        """Yield index and pixels of the wanted images, or what is wrong with one in a line."""


class FolderSource:
    """Images in a folder."""

    def __init__(self, folder: Path, calibration: Path, odometry: Path) -> None:
        """Read the poses of all images.

        Raises:
            FloorLocalizerError: odometry is missing or malformed.
            CameraFileError: the folder or the calibration cannot be read.
        """
        self.camera = load_calibration(calibration)
        self._paths = list_images([folder])
        poses = load_odometry(odometry, self._paths)
        self.frames = [Frame(path.name, pose) for path, pose in zip(self._paths, poses, strict=True)]

    def read(self, wanted: Sequence[int]) -> Iterator[tuple[int, Pixels | str]]:
        """Yield the wanted images."""
        for index in wanted:
            try:
                yield index, _sized(load_image(self._paths[index]), self.camera, str(self._paths[index]))
            except ImageFileError as fault:
                yield index, str(fault)


class BagSource:
    """The images of a bag, with its odometry and camera_info."""

    def __init__(self, path: Path, image: str | None, camera_info: str | None, odometry: str | None) -> None:
        """Read all stamps and poses.

        Raises:
            FloorLocalizerError: odometry is missing or runs backwards, or no image can be used.
            BagError: the bag or a topic is missing.
        """
        self._path = path
        with BagReader(path) as bag:
            self._topics = choose_topics(bag, image, camera_info, odometry)
            if not self._topics.odometry:
                raise FloorLocalizerError(
                    f'{path}: has no odometry; record nav_msgs/msg/Odometry along with the images'
                )
            trail = _read_trail(bag, self._topics.odometry)
            self.camera, stamps = _read_stamps(bag, self._topics)
        self.frames = [
            Frame(f'image {index} of {self._topics.images[0]}', trail.pose_at(stamp, f'image {index}'))
            for index, stamp in enumerate(stamps)
        ]

    def read(self, wanted: Sequence[int]) -> Iterator[tuple[int, Pixels | str]]:
        """Yield the wanted images."""
        chosen = set(wanted)
        topics = RecordingTopics(self._topics.images, self._topics.camera_infos)
        with BagReader(self._path) as bag:
            index = -1
            for message in Recording(bag, topics, camera_from_camera_info).messages():
                if not isinstance(message, RecordedImage | BadImage):
                    continue
                index += 1
                if index not in chosen:
                    continue
                if isinstance(message, BadImage):
                    yield index, message.fault
                else:
                    yield index, _sized(message.pixels, self.camera, message.topic)


def _sized(pixels: Pixels, camera: PinholeCamera, name: str) -> Pixels | str:
    height, width = pixels.shape[:2]
    if (width, height) == (camera.width, camera.height):
        return pixels
    return (
        f'{name}: is {width} x {height} px, the calibration is for {camera.width} x {camera.height} px; '
        'survey with images of one size'
    )


def _read_trail(bag: BagReader, topic: str) -> OdometryTrail:
    stamps, poses = [], []
    for message in Recording(bag, RecordingTopics((), (), topic), camera_from_camera_info).messages():
        if isinstance(message, RecordedOdometry):
            stamp = message.header.stamp
            stamps.append(stamp.sec * 1_000_000_000 + stamp.nanosec)
            poses.append((message.T_odom_base.x, message.T_odom_base.y, message.T_odom_base.yaw))
    return OdometryTrail(np.array(stamps, dtype=np.int64), np.array(poses).reshape(-1, 3), topic)


def _read_stamps(bag: BagReader, topics: RecordingTopics) -> tuple[PinholeCamera, list[int]]:
    """Return the calibration of the first image that has one, and the stamps of all images."""
    camera, stamps = None, []
    for message in Recording(
        bag, RecordingTopics(topics.images, topics.camera_infos), camera_from_camera_info
    ).messages():
        if isinstance(message, RecordedImage | BadImage):
            stamps.append(message.stamp_ns)
            if camera is None and isinstance(message, RecordedImage):
                camera = message.calibration
    if camera is None:
        raise FloorLocalizerError(
            f'{topics.images[0]}: no image comes with a calibration; record camera_info, too'
        )
    return camera, stamps
