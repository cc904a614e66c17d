"""Topics of the simulated robot: what it publishes and what it subscribes to."""

import json
from array import array
from collections import Counter, defaultdict
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Quaternion
from nav_msgs.msg import OccupancyGrid, Odometry
from numpy.typing import NDArray
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import Header, String

from scene_simulator.mission.layout import BELLY_CAMERA, CEILING_CAMERA
from scene_simulator.mission.sensors import DEPTH_CAMERA, STEREO_RIG
from scene_simulator.robot.leg_drive import TiltReading
from shirube_bringup.nodes import AREA
from shirube_bringup.record import GridMap, StatusCount
from shirube_bringup.render_worker import Picture
from shirube_core.geometry import SE2, PinholeCamera
from shirube_ros.camera.image import image_from_array
from shirube_ros.message_conversion import planar_pose, pose_stamped
from shirube_ros.quality_of_service import map_profile, pose_profile

START_SECONDS = 1000
"""ROS time at mission time 0 [s]; not 0, which means that simulated time has not started."""

_TILT_VARIANCES = (1e-6, 1e-6, float(np.pi**2))
"""Variances of roll, pitch and yaw, which the IMU does not measure [rad^2]."""

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


def mission_time(stamp: Time) -> float:
    """Return the mission time of a stamp [s]."""
    return float(stamp.sec - START_SECONDS + 1e-9 * stamp.nanosec)


def depth_image(depth: NDArray[np.float32], header: Header) -> Image:
    """Return a depth image, shape (height, width) [m], as a 32FC1 message."""
    height, width = depth.shape
    data = array('B')
    data.frombytes(np.ascontiguousarray(depth).data.cast('B'))
    return Image(header=header, height=height, width=width, encoding='32FC1', is_bigendian=0, step=4 * width, data=data)


def camera_info(camera: PinholeCamera, header: Header, baseline: float = 0.0) -> CameraInfo:
    """Return the calibration of a rectified camera, ``baseline`` to the right of the left one of its pair [m]."""
    projection = np.column_stack([camera.matrix, (-camera.fx * baseline, 0.0, 0.0)])
    return CameraInfo(
        header=header,
        height=camera.height,
        width=camera.width,
        distortion_model=camera.model.value,
        d=list(camera.distortion),
        k=camera.matrix.ravel(),
        r=np.eye(3).ravel(),
        p=projection.ravel(),
    )


def imu(reading: TiltReading, header: Header) -> Imu:
    """Return an IMU message with roll and pitch, without rates and accelerations."""
    x, y, z, w = Rotation.from_euler('xyz', (reading.roll, reading.pitch, 0.0)).as_quat().tolist()
    nothing = np.array([-1.0, *[0.0] * 8])
    return Imu(
        header=header,
        orientation=Quaternion(x=x, y=y, z=z, w=w),
        orientation_covariance=np.diag(_TILT_VARIANCES).ravel(),
        angular_velocity_covariance=nothing,
        linear_acceleration_covariance=nothing,
    )


class MissionPublishers:
    """All publishers of the simulation.

    Attributes:
        image_counts: number of images published per sensor.
    """

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


ODOMETRY = 'odometry'
LOCALIZERS = ('floor_localizer', 'vlc_beacon', 'stereo_landmark')


class StampedPose(NamedTuple):
    """A pose published by a node.

    Attributes:
        time: stamp in mission time [s].
        pose: ``T_map_base``, or ``T_odom_base`` of the wheels.
    """

    time: float
    pose: SE2


class MissionSubscribers:
    """Subscribes to poses, odometry, commands, diagnostics and the planner's map.

    Attributes:
        fixes: poses of each localizer, in order of arrival.
        fused: fused poses of the arbiter.
        areas: areas that the arbiter published for floor_localizer.
        odometry: wheel odometry, in order of arrival.
        odometry_time: stamp of the newest odometry [s].
        commands: commands of lamps, with the time of reception [s].
        planner: time [s] and text of the planner's latest status.
        trust: status counts of the arbiter, once a second.
        map: latest map of the planner, None before the first.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe."""
        self.fixes: dict[str, list[StampedPose]] = defaultdict(list)
        self.fused: list[StampedPose] = []
        self.areas: list[StampedPose] = []
        self.odometry: list[StampedPose] = []
        self.odometry_time = -1.0
        self.commands: list[tuple[float, str]] = []
        self.planner: tuple[float, str] = (-1.0, '')
        self.trust: list[StatusCount] = []
        self.map: GridMap | None = None
        self._node = node
        for name in LOCALIZERS:
            self._subscribe(PoseWithCovarianceStamped, f'/{name}/pose_with_covariance', self._make_fix_callback(name))
        self._subscribe(PoseStamped, '/pose_arbiter/pose', self._on_fused_pose)
        self._subscribe(PoseWithCovarianceStamped, AREA, self._on_area)
        self._subscribe(Odometry, '/odom', self._on_odometry)
        self._subscribe(String, '/vlc_beacon/command', self._on_command)
        self._subscribe(DiagnosticArray, '/diagnostics', self._on_diagnostics)
        node.create_subscription(OccupancyGrid, '/reward_planner/map', self._on_map, map_profile())

    def _subscribe(self, kind: type, topic: str, callback: object) -> None:
        self._node.create_subscription(kind, topic, callback, pose_profile())

    def _make_fix_callback(self, name: str) -> object:
        def callback(message: PoseWithCovarianceStamped) -> None:
            pose = planar_pose(message.pose.pose, name)
            self.fixes[name].append(StampedPose(mission_time(message.header.stamp), pose))

        return callback

    def _on_fused_pose(self, message: PoseStamped) -> None:
        pose = planar_pose(message.pose, 'pose')
        self.fused.append(StampedPose(mission_time(message.header.stamp), pose))

    def _on_area(self, message: PoseWithCovarianceStamped) -> None:
        pose = planar_pose(message.pose.pose, AREA)
        self.areas.append(StampedPose(mission_time(message.header.stamp), pose))

    def _on_odometry(self, message: Odometry) -> None:
        self.odometry_time = mission_time(message.header.stamp)
        self.odometry.append(StampedPose(self.odometry_time, planar_pose(message.pose.pose, 'odom')))

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
