"""Records further data for the report: status counts of the arbiter, wheel odometry, the planner's map."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node

from shirube_bringup.mission_messages import mission_time
from shirube_bringup.mission_subscribers import LOCALIZERS, StampedPose
from shirube_bringup.mission_traces import GridMap, StatusCount
from shirube_ros.pose_conversion import planar_pose
from shirube_ros.quality_of_service import map_profile, pose_profile

ODOMETRY = 'odometry'


class TraceRecorder:
    """Subscribes to odometry, the arbiter's diagnostics and the planner's map.

    Attributes:
        odometry: ``T_odom_base`` of each message, in order of arrival.
        trust: status counts of the arbiter, once a second.
        map: latest map of the planner, None before the first.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe.

        Args:
            node: node that subscribes.
        """
        self.odometry: list[StampedPose] = []
        self.trust: list[StatusCount] = []
        self.map: GridMap | None = None
        node.create_subscription(Odometry, '/odom', self._on_odometry, pose_profile())
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, pose_profile())
        node.create_subscription(OccupancyGrid, '/reward_planner/map', self._on_map, map_profile())

    def _on_odometry(self, message: Odometry) -> None:
        pose = planar_pose(message.pose.pose, 'odom')
        self.odometry.append(StampedPose(mission_time(message.header.stamp), pose))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        time = mission_time(message.header.stamp)
        for status in message.status:
            if 'pose_arbiter' in status.name:
                for entry in status.values:
                    source, _, verdict = entry.key.partition(': ')
                    if source in LOCALIZERS and verdict:
                        self.trust.append(StatusCount(time, source, verdict, int(entry.value)))

    def _on_map(self, message: OccupancyGrid) -> None:
        info = message.info
        self.map = GridMap(
            (info.origin.position.x, info.origin.position.y),
            info.resolution,
            (info.height, info.width),
            message.data.tolist(),
        )
