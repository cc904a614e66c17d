"""Which topics of a bag a method sees."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_bags.bag_reader import BagReader
from shirube_bags.topic_choice import choose_topic

_IMAGES = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage')


@dataclass(frozen=True)
class RecordingTopics:
    """Names of topics; an empty one is none.

    Attributes:
        images: of the cameras, raw or compressed.
        camera_infos: their calibrations, in the same order.
        odometry: of the wheels.
        imu: whose orientation tells how the robot leans.
    """

    images: tuple[str, ...]
    camera_infos: tuple[str, ...]
    odometry: str = ''
    imu: str = ''

    @property
    def wanted(self) -> list[str]:
        """All that are not empty."""
        return [name for name in (*self.images, *self.camera_infos, self.odometry, self.imu) if name]


def choose_images(
    bag: BagReader, name: str | None, usual: tuple[str, ...] = ('/image_raw', '/image_raw/compressed')
) -> str:
    """Return the topic of a camera's images: the named one, else a usual one, else the only one.

    Raises:
        BagError: the named topic is missing or of another type, or none or several are there to choose from.
    """
    return choose_topic(bag, name, _IMAGES, usual)


def choose_camera_info(bag: BagReader, name: str | None, usual: str = '/camera_info') -> str:
    """Return the topic of a camera's calibration; as `choose_images`."""
    return choose_topic(bag, name, ('sensor_msgs/msg/CameraInfo',), (usual,))


def choose_odometry(bag: BagReader, name: str | None) -> str:
    """Return the topic of the odometry, empty if there is none; as `choose_images`."""
    return choose_topic(bag, name, ('nav_msgs/msg/Odometry',), ('/odom',), is_optional=True)


def choose_imu(bag: BagReader, name: str | None) -> str:
    """Return the topic of the inertial unit, empty if there is none; as `choose_images`."""
    return choose_topic(bag, name, ('sensor_msgs/msg/Imu',), ('/imu',), is_optional=True)
