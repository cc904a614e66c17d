"""The node in an isolated graph, and a simulated robot in a room."""

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped
from node_testing import NodeUser, cloud_from_points
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from simulated_robot import MotorLimits, SimulatedRobot
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from reward_planner.node import RewardPlannerNode
from scene_simulator.room.box_room import BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import SE2, PinholeCamera
from shirube_ros.message_conversion import pose_stamped

CAMERA = PinholeCamera(80, 60, 60.0, 60.0, 39.5, 29.5)
ROOM = BoxRoom((-1.0, -2.0, 0.0, 5.0, 2.0, 2.5), ((1.6, -0.4, 0.0, 2.0, 0.5, 1.0),))
START = SE2(0.0, 0.0, 0.0)
AHEAD = SE2(3.5, 0.0, 0.0)
TOPICS = {
    'points': PointCloud2,
    'pose': PoseStamped,
    'goal_pose': PoseStamped,
    'command': String,
    'depth/image': Image,
    'depth/camera_info': CameraInfo,
}


class Robot(NodeUser):
    """The node under test and a simulated robot, in simulated time."""

    def __init__(self, graph, **parameters):
        self._graph = graph
        self.now = 100.0
        self.body = SimulatedRobot(START, MotorLimits(1.0, 6.0))
        parameters = {'use_sim_time': True, 'planning_thread': False, 'resolution': 0.1, 'range_max': 4.0} | parameters
        self.node = graph.add(RewardPlannerNode, **parameters)
        self.robot = graph.add(lambda **options: Node('robot', **options))
        self._clock = self.robot.create_publisher(Clock, '/clock', 10)
        topics = ['pose', 'goal_pose', 'command']
        topics += ['depth/image', 'depth/camera_info'] if parameters.get('source') == 'depth' else ['points']
        self.publishers = {t: self.robot.create_publisher(TOPICS[t], t, 10) for t in topics}
        self.reports, self.velocities = [], []
        self.robot.create_subscription(
            DiagnosticArray, '/diagnostics', lambda array: self.reports.extend(array.status), 10
        )
        self.robot.create_subscription(TwistStamped, 'cmd_vel', self.velocities.append, 10)
        assert graph.spin_until(
            lambda: (
                all(p.get_subscription_count() == 1 for p in self.publishers.values())
                and self._clock.get_subscription_count() >= 1
            )
        )
        self.tick(0.0)

    def tick(self, seconds):
        """Advance simulated time."""
        self.now += seconds
        self._clock.publish(Clock(clock=stamp(self.now)))
        aim = round(self.now * 1e9) - 1000
        assert self._graph.spin_until(lambda: self.node.get_clock().now().nanoseconds >= aim)

    def listen(self, kind, topic, profile=10):
        received = []
        self.robot.create_subscription(kind, topic, received.append, profile)
        assert self._graph.spin_until(lambda: self.robot.count_publishers(topic) == 1)
        return received

    def header(self, frame='map', ago=0.0):
        return Header(stamp=stamp(self.now - ago), frame_id=frame)

    def send_pose(self, pose=None, frame='map'):
        self.send('pose', pose_stamped(pose or self.body.pose_at(self.body.time), self.header(frame)))

    def send_goal(self, pose, frame='map'):
        self.send('goal_pose', pose_stamped(pose, self.header(frame)))

    def send_points(self, frame='camera_optical_frame', ago=0.0):
        pose = self.body.pose_at(self.body.time)
        depth = ROOM.depth_image(CAMERA, forward_camera(pose.x, pose.y, 0.3, pose.yaw))
        points = points_from_depth(depth, CAMERA)
        self.send('points', cloud_from_points(points.astype(np.float32), self.header(frame, ago)))

    def drive(self, seconds, until=lambda: False):
        """Publish points and pose, and drive, ten times per simulated second."""
        for _ in range(round(10 * seconds)):
            self.send_points()
            self.send_pose()
            self.cycle()
            twist = self.velocities[-1].twist if self.velocities else TwistStamped().twist
            self.body.drive(twist.linear.x, twist.angular.z, self.body.time + 0.1)
            if until():
                return

    def cycle(self):
        """Advance a tenth of a second; wait for the control cycle and its velocity, if one is published."""
        cycles, received = self.node._guard.counts['control loop'], len(self.velocities)
        before = cycles.received
        self.tick(0.1)
        assert self._graph.spin_until(lambda: cycles.received > before)
        drive = self.node._report._drive
        if self.node._cmd_vel is not None and drive is not None and drive.velocity is not None:
            assert self._graph.spin_until(lambda: len(self.velocities) > received)

    def refusals(self, topic):
        return list(self.node._guard.counts[topic].rejected)

    def message(self):
        """The next diagnostic status."""
        before = len(self.reports)
        assert self._graph.spin_until(lambda: len(self.reports) > before)
        return self.reports[-1]

    def call(self, service):
        client = self.robot.create_client(Trigger, f'/reward_planner/{service}')
        assert self._graph.spin_until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        assert self._graph.spin_until(future.done)
        return future.result()

    def drive_to(self, goal, seconds=1.0):
        """Map the surroundings, set a goal and drive."""
        self.drive(0.3)
        self.send_goal(goal)
        self.drive(seconds)

    @property
    def speed(self):
        return self.velocities[-1].twist.linear.x if self.velocities else 0.0


def stamp(seconds):
    sec, nanosec = divmod(round(seconds * 1e9), 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)
