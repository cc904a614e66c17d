"""Publishers of the simulation: clock, sensor data, ground truth and goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial

from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import Header

from scene_simulator.mission_floor import BELLY_CAMERA
from scene_simulator.mission_lamps import CEILING_CAMERA
from scene_simulator.mission_sensors import DEPTH_CAMERA, STEREO_RIG
from scene_simulator.tilt_sensor import TiltReading
from shirube_bringup.mission_messages import camera_info, depth_image, imu, stamp_of
from shirube_bringup.render_worker import Picture
from shirube_core.geometry import SE2
from shirube_ros.camera.image import image_from_array
from shirube_ros.pose_conversion import pose_stamped
from shirube_ros.quality_of_service import pose_profile

_STEREO = STEREO_RIG.left.intrinsics
_CAMERAS = {
    'floor': (('/floor/image_raw', BELLY_CAMERA.intrinsics, 0.0),),
    'ceiling': (('/ceiling/image_raw', CEILING_CAMERA.intrinsics, 0.0),),
    'stereo': (
        ('/left/image_rect', _STEREO, 0.0),
        ('/right/image_rect', _STEREO, STEREO_RIG.baseline),
    ),
    'depth': (('/depth/image', DEPTH_CAMERA, 0.0),),
}
"""Topic, intrinsics and baseline of the cameras of each sensor."""


class MissionPublishers:
    """All publishers of the simulation.

    Attributes:
        image_counts: number of images published per sensor.
    """

    def __init__(self, node: Node) -> None:
        """Create the publishers.

        Args:
            node: node that publishes.
        """
        self.image_counts = Counter[str]()
        create_publisher = partial(node.create_publisher, qos_profile=pose_profile())
        self._clock = create_publisher(Clock, '/clock')
        self._truth = create_publisher(PoseStamped, '/ground_truth')
        self._goal = create_publisher(PoseStamped, '/goal_pose')
        self._imu = create_publisher(Imu, '/imu')
        self._images = {}
        for topic, _, _ in (camera for group in _CAMERAS.values() for camera in group):
            info = f'{topic.rpartition("/")[0]}/camera_info'
            self._images[topic] = create_publisher(Image, topic), create_publisher(CameraInfo, info)

    def subscriber_count(self, sensor: str) -> int:
        """Return the smallest number of subscribers of a sensor's image topics."""
        return min(self._images[topic][0].get_subscription_count() for topic, _, _ in _CAMERAS[sensor])

    def publish_clock(self, now: int) -> None:
        """Publish a mission time [ms] on /clock."""
        self._clock.publish(Clock(clock=stamp_of(now)))

    def publish_ground_truth(self, now: int, pose: SE2) -> None:
        """Publish the true pose at a time [ms]."""
        self._truth.publish(pose_stamped(pose, Header(stamp=stamp_of(now), frame_id='map')))

    def publish_goal(self, now: int, goal: SE2) -> None:
        """Publish a goal at a time [ms]."""
        self._goal.publish(pose_stamped(goal, Header(stamp=stamp_of(now), frame_id='map')))

    def publish_imu(self, time: int, reading: TiltReading) -> None:
        """Publish an IMU reading at a time [ms]."""
        self._imu.publish(imu(reading, Header(stamp=stamp_of(time), frame_id='base_link')))

    def publish_images(self, sensor: str, time: int, pictures: Sequence[Picture]) -> None:
        """Publish the images of a sensor at a time [ms], each after its CameraInfo."""
        self.image_counts[sensor] += 1
        for (topic, camera, baseline), picture in zip(_CAMERAS[sensor], pictures, strict=True):
            frame = f'{topic.split("/")[1]}_camera_optical_frame'
            header = Header(stamp=stamp_of(time), frame_id=frame)
            image, info = self._images[topic]
            info.publish(camera_info(camera, header, baseline))
            to_message = depth_image if picture.dtype.kind == 'f' else image_from_array
            image.publish(to_message(picture, header))
