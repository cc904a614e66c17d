"""Topics of the simulated robot: what it publishes and what it subscribes to."""

import json
from array import array
from collections import Counter
from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from numpy.typing import NDArray
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import Header, String

from scene_simulator import messages
from scene_simulator.mission.layout import BELLY_CAMERA, CEILING_CAMERA
from scene_simulator.mission.sensors import DEPTH_CAMERA, STEREO_RIG
from scene_simulator.robot.leg_drive import TiltReading
from shirube_bags.bag_reader import jazzy_types
from shirube_bags.stamps import NANOSECONDS
from shirube_bringup.nodes import AREA
from shirube_bringup.record import GridMap, StatusCount
from shirube_bringup.render_worker import Picture
from shirube_core.geometry import SE2
from shirube_ros.camera.image import image_from_array
from shirube_ros.message_conversion import planar_pose, pose_stamped
from shirube_ros.quality_of_service import map_profile, pose_profile

START_SECONDS = 1000  # ROS time at mission time 0 [s]; not 0, which means that simulated time has not started
_STEREO = STEREO_RIG.left.intrinsics
_CAMERAS = {
    'floor': (('/floor/image_raw', BELLY_CAMERA.intrinsics, 0.0),),
    'ceiling': (('/ceiling/image_raw', CEILING_CAMERA.intrinsics, 0.0),),
    'stereo': (('/left/image_rect', _STEREO, 0.0), ('/right/image_rect', _STEREO, STEREO_RIG.baseline)),
    'depth': (('/depth/image', DEPTH_CAMERA, 0.0),),
}
"""Topic, intrinsics and baseline of the cameras of each sensor."""


def stamp_of(milliseconds: int) -> Time:
    """Return the ROS stamp of a mission time [ms]."""
    seconds, rest = divmod(milliseconds, 1000)
    return Time(sec=START_SECONDS + seconds, nanosec=1_000_000 * rest)


def stamp_ns(milliseconds: int) -> int:
    """Return the ROS stamp of a mission time [ms] in nanoseconds."""
    return START_SECONDS * NANOSECONDS + 1_000_000 * milliseconds


def mission_time(stamp: Time) -> float:
    """Return the mission time of a stamp [s]."""
    return float(stamp.sec - START_SECONDS + 1e-9 * stamp.nanosec)


def depth_image(depth: NDArray[np.float32], header: Header) -> Image:
    """Return a depth image, shape (height, width) [m], as a 32FC1 message."""
    height, width = depth.shape
    data = array('B')
    data.frombytes(np.ascontiguousarray(depth).data.cast('B'))
    return Image(header=header, height=height, width=width, encoding='32FC1', is_bigendian=0, step=4 * width, data=data)


def _serialized(message: Any) -> bytes:
    return bytes(jazzy_types().serialize_cdr(message, message.__msgtype__))


class MissionPublishers:
    """All publishers of the simulation; ``image_counts`` are the images published per sensor."""

    def __init__(self, node: Node) -> None:
        """Create the publishers."""
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
        self._imu.publish(_serialized(messages.imu(reading, 'base_link', stamp_ns(time))))

    def publish_images(self, sensor: str, time: int, pictures: Sequence[Picture]) -> None:
        """Publish the images of a sensor at a time [ms], each after its CameraInfo."""
        self.image_counts[sensor] += 1
        for (topic, camera, baseline), picture in zip(_CAMERAS[sensor], pictures, strict=True):
            frame = f'{topic.split("/")[1]}_camera_optical_frame'
            header = Header(stamp=stamp_of(time), frame_id=frame)
            image, info = self._images[topic]
            projection = np.column_stack([camera.matrix, (-camera.fx * baseline, 0.0, 0.0)])
            info.publish(_serialized(messages.camera_info(camera, frame, stamp_ns(time), projection=projection)))
            to_message = depth_image if picture.dtype.kind == 'f' else image_from_array
            image.publish(to_message(picture, header))


ODOMETRY = 'odometry'
LOCALIZERS = ('floor_localizer', 'vlc_beacon', 'stereo_landmark')


class StampedPose(NamedTuple):
    """A published pose at a mission time [s]: ``T_map_base``, or ``T_odom_base`` of the wheels."""

    time: float
    pose: SE2


def _keep_pose(poses: list[StampedPose], topic: str, message: Any) -> None:
    pose = message.pose if isinstance(message, PoseStamped) else message.pose.pose
    poses.append(StampedPose(mission_time(message.header.stamp), planar_pose(pose, topic)))


class MissionSubscribers:
    """Subscribes to poses, odometry, commands, diagnostics and the planner's map.

    Attributes:
        fixes: poses of each localizer, in order of arrival.
        fused: fused poses of the arbiter.
        areas: areas that the arbiter published for floor_localizer.
        odometry: wheel odometry, in order of arrival.
        commands: commands of lamps, with the time of reception [s].
        planner: time [s] and text of the planner's latest status.
        trust: status counts of the arbiter, once a second.
        map: latest map of the planner, None before the first.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe."""
        self.fixes: dict[str, list[StampedPose]] = {name: [] for name in LOCALIZERS}
        self.fused: list[StampedPose] = []
        self.areas: list[StampedPose] = []
        self.odometry: list[StampedPose] = []
        self.commands: list[tuple[float, str]] = []
        self.planner: tuple[float, str] = (-1.0, '')
        self.trust: list[StatusCount] = []
        self.map: GridMap | None = None
        self._node = node
        kept: dict[str, tuple[type, list[StampedPose]]] = {
            **{f'/{name}/pose_with_covariance': (PoseWithCovarianceStamped, self.fixes[name]) for name in LOCALIZERS},
            '/pose_arbiter/pose': (PoseStamped, self.fused),
            AREA: (PoseWithCovarianceStamped, self.areas),
            '/odom': (Odometry, self.odometry),
        }
        for topic, (kind, poses) in kept.items():
            self._subscribe(kind, topic, partial(_keep_pose, poses, topic))
        self._subscribe(String, '/vlc_beacon/command', self._on_command)
        self._subscribe(DiagnosticArray, '/diagnostics', self._on_diagnostics)
        node.create_subscription(OccupancyGrid, '/reward_planner/map', self._on_map, map_profile())

    def _subscribe(self, kind: type, topic: str, callback: object) -> None:
        self._node.create_subscription(kind, topic, callback, pose_profile())

    @property
    def odometry_time(self) -> float:
        """Stamp of the newest odometry [s], -1 before the first."""
        return self.odometry[-1].time if self.odometry else -1.0

    def _on_command(self, message: String) -> None:
        command = json.loads(message.data)
        self.commands.append((self.odometry_time, f'{command["op"]} {command["value"]:g}'))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        time = mission_time(message.header.stamp)
        for status in message.status:
            if 'reward_planner' in status.name:
                self.planner = time, status.message
            elif 'pose_arbiter' in status.name:
                for entry in status.values:
                    source, _, verdict = entry.key.partition(': ')
                    if source in LOCALIZERS and verdict:
                        self.trust.append(StatusCount(time, source, verdict, int(entry.value)))

    def _on_map(self, message: OccupancyGrid) -> None:
        info = message.info
        corner, shape = info.origin.position, (info.height, info.width)
        self.map = GridMap((corner.x, corner.y), info.resolution, shape, message.data.tolist())
