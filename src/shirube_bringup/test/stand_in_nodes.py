"""Nodes that store their messages; bridge and arbiter also publish for each time step."""

from __future__ import annotations

from functools import partial

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, Imu
from std_msgs.msg import Header

from shirube_bringup.publishers import mission_time

TOPICS = {
    'floor_localizer': ('/floor/image_raw',),
    'vlc_beacon': ('/ceiling/image_raw',),
    'stereo_landmark': ('/left/image_rect', '/right/image_rect'),
    'reward_planner': ('/depth/image',),
    'motor_bridge': (),
    'pose_arbiter': (),
}


class StubNode(Node):
    """A stub of a mission node."""

    def __init__(self, name: str, **options: object) -> None:
        super().__init__(name, **options)
        self.received: list[tuple[str, float, float]] = []
        self.clock_times: list[float] = []
        self.tilts: list[float] = []
        for topic in TOPICS[name]:
            self.create_subscription(Image, topic, partial(self.store, topic), 10)
        self.create_subscription(Clock, '/clock', self.on_clock, 10)
        self.create_subscription(Imu, '/imu', lambda m: self.tilts.append(mission_time(m.header.stamp)), 10)
        self.odometry = self.create_publisher(Odometry, '/odom', 10)
        self.pose = self.create_publisher(PoseStamped, '/pose_arbiter/pose', 10)

    def store(self, topic: str, message: Image) -> None:
        """Store topic, stamp and the latest clock time."""
        self.received.append(
            (topic, mission_time(message.header.stamp), self.clock_times[-1] if self.clock_times else 0)
        )

    def on_clock(self, message: Clock) -> None:
        """Publish as the real node would."""
        self.clock_times.append(mission_time(message.clock))
        header = Header(stamp=message.clock, frame_id='map')
        if self.get_name() == 'motor_bridge':
            self.odometry.publish(Odometry(header=header))
        if self.get_name() == 'pose_arbiter':
            message = PoseStamped(header=header)
            message.pose.orientation.w = 1.0
            self.pose.publish(message)
