"""Subscribers that store what the nodes publish during the mission."""

import json
from collections import defaultdict
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from std_msgs.msg import String

from shirube_bringup.nodes import AREA
from shirube_bringup.publishers import mission_time
from shirube_bringup.record import GridMap, StatusCount
from shirube_core.geometry import SE2
from shirube_ros.pose_conversion import planar_pose
from shirube_ros.quality_of_service import map_profile, pose_profile

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
