"""Selection of the topics to read from a bag."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_bags.bag_reader import BagReader
from shirube_bags.topic_selection import select_topic

_IMAGES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')


@dataclass(frozen=True)
class RecordingTopics:
    """Names of topics; an empty name means no topic.

    Attributes:
        images: topics of the images, raw or compressed.
        camera_infos: topics of the calibrations, in the same order.
        odometry: topic of the wheel odometry.
        imu: topic of the IMU, whose orientation gives the tilt.
    """

    images: tuple[str, ...]
    camera_infos: tuple[str, ...]
    odometry: str = ''
    imu: str = ''

    @property
    def wanted(self) -> list[str]:
        """All topics that are not empty."""
        return [name for name in (*self.images, *self.camera_infos, self.odometry, self.imu) if name]


def choose_images(
    bag: BagReader, name: str | None, default: tuple[str, ...] = ('/image_raw', '/image_raw/compressed')
) -> str:
    """Return the image topic of a camera: the named one, else a default one, else the only one.

    Raises:
        BagError: the named topic is missing or has another type, or the choice is not unique.
    """
    return select_topic(bag, name, _IMAGES, default)


def choose_camera_info(bag: BagReader, name: str | None, default: str = '/camera_info') -> str:
    """Return the CameraInfo topic of a camera; see `choose_images`."""
    return select_topic(bag, name, ('sensor_msgs/msg/CameraInfo',), (default,))


def choose_odometry(bag: BagReader, name: str | None) -> str:
    """Return the odometry topic, empty if there is none; see `choose_images`."""
    return select_topic(bag, name, ('nav_msgs/msg/Odometry',), ('/odom',), is_optional=True)


def choose_imu(bag: BagReader, name: str | None) -> str:
    """Return the IMU topic, empty if there is none; see `choose_images`."""
    return select_topic(bag, name, ('sensor_msgs/msg/Imu',), ('/imu',), is_optional=True)
