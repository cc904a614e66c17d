"""Subscribers that store the messages of the nodes during the mission."""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import String

from shirube_geometry import PlanarPose
from shirube_mission.mission_messages import mission_time
from shirube_ros.pose_conversion import planar_pose
from shirube_ros.quality_of_service import pose_profile

LOCALIZERS = ('floor_localizer', 'vlc_beacon', 'stereo_landmark')


@dataclass(frozen=True)
class StampedPose:
    """A pose published by a node.

    Attributes:
        time: stamp in mission time [s].
        pose: ``T_map_base``.
    """

    time: float
    pose: PlanarPose


class MissionEars:
    """Subscribes to poses, odometry, commands and the planner's diagnostics.

    Attributes:
        fixes: poses of each localizer, in order of arrival.
        fused: fused poses of the arbiter.
        odometry_time: stamp of the newest odometry [s].
        commands: commands of lamps, with the time of reception [s].
        planner: time [s] and text of the planner's latest status.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
        """
        self.fixes: dict[str, list[StampedPose]] = defaultdict(list)
        self.fused: list[StampedPose] = []
        self.odometry_time = -1.0
        self.orders: list[tuple[float, str]] = []
        self.planner: tuple[float, str] = (-1.0, '')
        self._node = node
        for name in LOCALIZERS:
            self._listen(PoseWithCovarianceStamped, f'/{name}/pose_with_covariance', self._keeper_of(name))
        self._listen(PoseStamped, '/pose_arbiter/pose', self._take_fused)
        self._listen(Odometry, '/odom', self._take_odometry)
        self._listen(String, '/vlc_beacon/command', self._take_order)
        self._listen(DiagnosticArray, '/diagnostics', self._take_diagnostics)

    def _listen(self, kind: type, topic: str, take: object) -> None:
        self._node.create_subscription(kind, topic, take, pose_profile())

    def _keeper_of(self, name: str) -> object:
        def keep(message: PoseWithCovarianceStamped) -> None:
            pose = planar_pose(message.pose.pose, name)
            self.fixes[name].append(StampedPose(mission_time(message.header.stamp), pose))

        return keep

    def _take_fused(self, message: PoseStamped) -> None:
        pose = planar_pose(message.pose, 'pose')
        self.fused.append(StampedPose(mission_time(message.header.stamp), pose))

    def _take_odometry(self, message: Odometry) -> None:
        self.odometry_time = mission_time(message.header.stamp)

    def _take_order(self, message: String) -> None:
        order = json.loads(message.data)
        self.orders.append((self.odometry_time, f'{order["op"]} {order["value"]:g}'))

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if 'reward_planner' in status.name:
                self.planner = (mission_time(message.header.stamp), status.message)
