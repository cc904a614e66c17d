"""A simulated robot for the live planner: publishes poses and clouds of the floor, and follows cmd_vel."""

from __future__ import annotations

import math
import subprocess
from time import monotonic

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from shirube_core.geometry import SE2
from shirube_ros.pose_conversion import pose_stamped

_FLOOR = np.stack(np.meshgrid(np.linspace(0.5, 3.0, 80), np.linspace(-1.5, 1.5, 60)), axis=-1).reshape(-1, 2)


class PlannerRobot:
    """The robot and its clock of real time."""

    def __init__(self, start: tuple[float, float]) -> None:
        """Start at rest at a place [m]."""
        self.node = rclpy.create_node('robot')
        self.pose, self.command_times = SE2(*start, math.pi / 2.0), list[float]()
        self._velocity, self._obstacle = (0.0, 0.0), np.empty((0, 2))
        self._poses = self.node.create_publisher(PoseStamped, 'pose', 10)
        self._goals = self.node.create_publisher(PoseStamped, 'goal_pose', 10)
        self._clouds = self.node.create_publisher(PointCloud2, 'points', qos_profile_sensor_data)
        self.node.create_subscription(TwistStamped, 'cmd_vel', self._take, 10)

    @property
    def position(self) -> tuple[float, float]:
        """Place of the robot [m]."""
        return self.pose.x, self.pose.y

    def _take(self, message: TwistStamped) -> None:
        self.command_times.append(monotonic())
        self._velocity = message.twist.linear.x, message.twist.angular.z

    def wait_for_planner(self, process: subprocess.Popen[bytes], seconds: float) -> None:
        """Wait until the node of a process subscribes; raise a RuntimeError after a time [s]."""
        end = monotonic() + seconds
        while not all(p.get_subscription_count() for p in (self._poses, self._goals, self._clouds)):
            rclpy.spin_once(self.node, timeout_sec=0.1)
            if monotonic() > end or process.poll() is not None:
                raise RuntimeError('the node does not start')

    def send_goal(self, x: float, y: float) -> None:
        """Publish a goal [m]."""
        self._goals.publish(pose_stamped(SE2(x, y, 0.0), self._header('map')))

    def add_obstacle(self, ahead: float) -> None:
        """Put a box of 1 m some distance ahead of the robot [m]."""
        sides = np.stack(np.meshgrid(ahead + np.linspace(0.0, 0.1, 5), np.linspace(-0.5, 0.5, 60)), axis=-1)
        self._obstacle = self.pose.transform(sides.reshape(-1, 2))

    def run(self, seconds: float, period: float) -> None:
        """Drive for some time in steps of a period [s]: a pose each, a cloud each second one."""
        begin = monotonic()
        for step in range(round(seconds / period)):
            forward, turn = (period * number for number in self._velocity)
            self.pose = self.pose @ SE2(forward, 0.0, turn)
            self._poses.publish(pose_stamped(self.pose, self._header('map')))
            if step % 2 == 0:
                self._publish_cloud()
            while (left := begin + period * (step + 1) - monotonic()) > 0.0:
                rclpy.spin_once(self.node, timeout_sec=left)

    def _header(self, frame: str) -> Header:
        return Header(stamp=self.node.get_clock().now().to_msg(), frame_id=frame)

    def _publish_cloud(self) -> None:
        boxes = self.pose.inverse().transform(self._obstacle) if len(self._obstacle) else self._obstacle
        heights = np.linspace(0.15, 0.6, 4)
        walls = [np.column_stack([boxes, np.full(len(boxes), height)]) for height in heights]
        points = np.concatenate([np.column_stack([_FLOOR, np.zeros(len(_FLOOR))]), *walls]).astype('<f4')
        fields = [
            PointField(name='xyz'[k], offset=4 * k, datatype=PointField.FLOAT32, count=1) for k in range(3)
        ]
        self._clouds.publish(PointCloud2(header=self._header('base_link'), height=1, width=len(points), fields=fields,
                                         point_step=12, row_step=12 * len(points), data=points.tobytes()))  # fmt: skip
