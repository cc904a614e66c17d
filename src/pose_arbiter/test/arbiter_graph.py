"""The node in an isolated graph, and a simulated robot whose clock the test sets."""

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from node_testing import NodeUser
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header
from std_srvs.srv import Trigger

from pose_arbiter.node import PoseArbiterNode
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import odometry_message, pose_stamped, pose_with_covariance_stamped

START = 100.0
NOISE = np.diag([1e-4, 1e-4, 1e-4])


class Robot(NodeUser):
    """Drives along x at 0.5 m/s; `a` publishes poses with covariance, `b` without."""

    def __init__(self, graph, *, clock=True, **parameters):
        self._graph, self.now = graph, START
        parameters = {'use_sim_time': True, 'sources': ['a', 'b'], 'b.with_covariance': False} | parameters
        self.node = graph.add(PoseArbiterNode, **parameters)
        self.robot = graph.add(lambda **options: Node('robot', **options))
        self._clock = self.robot.create_publisher(Clock, '/clock', 10)
        kinds = {
            'a': (PoseWithCovarianceStamped, '/a/pose_with_covariance'),
            'b': (PoseStamped, '/b/pose'),
            'odom': (Odometry, 'odom'),
            'initialpose': (PoseWithCovarianceStamped, 'initialpose'),
        }
        self.publishers = {name: self.robot.create_publisher(kind, topic, 10) for name, (kind, topic) in kinds.items()}
        self.poses, self.odometry, self.reports = [], [], []
        listen = self.robot.create_subscription
        listen(PoseStamped, '/pose_arbiter/pose', self.poses.append, 100)
        listen(Odometry, '/pose_arbiter/odometry', self.odometry.append, 100)
        listen(DiagnosticArray, '/diagnostics', lambda array: self.reports.extend(array.status), 10)
        assert graph.spin_until(
            lambda: (
                all(p.get_subscription_count() == 1 for p in self.publishers.values())
                and self._clock.get_subscription_count() >= 1
                and self.robot.count_publishers('/pose_arbiter/pose') == 1
                and self.robot.count_publishers('/pose_arbiter/odometry') == 1
            )
        )
        if clock:
            self.tick(0.0)

    @property
    def pose(self):
        return SE2(0.5 * (self.now - START), 0.0, 0.0)

    def tick(self, seconds):
        """Advance the clock of the node."""
        self.now += seconds
        self._clock.publish(Clock(clock=stamp(self.now)))
        expected = round(self.now * 1e9)
        assert self._graph.spin_until(lambda: abs(self.node.get_clock().now().nanoseconds - expected) < 1000)

    def header(self, frame='map', ago=0.0):
        return Header(stamp=stamp(self.now - ago), frame_id=frame)

    def publish_a(self, pose=None, noise=NOISE, **header):
        self.send('a', pose_with_covariance_stamped(pose or self.pose, noise, self.header(**header)))

    def publish_b(self, pose=None, **header):
        self.send('b', pose_stamped(pose or self.pose, self.header(**header)))

    def publish_odometry(self, pose=None):
        pose = pose or SE2(5.0, 5.0, 0.0) @ self.pose
        message = odometry_message(pose, NOISE, self.header('odom'), 'base_link')
        message.twist.twist.linear.x = 0.5
        self.send('odom', message)

    def drive(self, seconds, a=True, b=True):
        """Drive in steps of 0.1 s; a and b may be functions of the true pose."""
        for _ in range(round(10 * seconds)):
            self.tick(0.1)
            self.publish_odometry()
            for source, publish in ((a, self.publish_a), (b, self.publish_b)):
                if source:
                    publish(source(self.pose) if callable(source) else None)
        self._graph.spin_until(lambda: bool(self.poses) and seconds_of(self.poses[-1]) > self.now - 0.025, 5.0)

    def refusals(self, name):
        return list(self.node._guard.counts[name].rejected)

    def call_reset(self):
        client = self.robot.create_client(Trigger, '/pose_arbiter/reset')
        assert self._graph.spin_until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        assert self._graph.spin_until(future.done)
        return future.result()


def stamp(seconds):
    sec, nanosec = divmod(round(seconds * 1e9), 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)


def seconds_of(message):
    return message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
