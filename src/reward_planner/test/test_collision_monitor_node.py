"""The node collision_monitor in an isolated graph: velocities, sources of each kind, what it refuses."""

import json
import math
from array import array

import numpy as np
import pytest
from geometry_msgs.msg import PolygonStamped, Twist, TwistStamped
from node_testing import cloud_from_points, run_in_process
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2
from std_msgs.msg import Header, String

from reward_planner.collision_monitor_node import CollisionMonitorNode, main

WALL = np.array([[0.4, 0.01 * k, 0.3] for k in range(-40, 40)], dtype=np.float32)
"""Points in the base frame, within the stop zone of the default robot at its stopping distance."""
FAR = WALL + np.float32([4.0, 0.0, 0.0])


class Robot:
    """The node and one that commands and measures."""

    def __init__(self, graph, kind=TwistStamped, **parameters):
        self.graph = graph
        self.monitor = graph.add(CollisionMonitorNode, **parameters)
        self.robot = graph.node('robot')
        self.velocities, self.states, self.zones = [], [], []
        self.commands = self.robot.create_publisher(kind, 'cmd_vel_in', 10)
        self.robot.create_subscription(kind, 'cmd_vel', self.velocities.append, 10)
        self.robot.create_subscription(String, '/collision_monitor/state', self.states.append, 10)
        zone = '/collision_monitor/stop_zone'
        self.robot.create_subscription(PolygonStamped, zone, self.zones.append, 10)
        self.ready(self.commands)

    def ready(self, publisher):
        assert self.graph.spin_until(lambda: publisher.get_subscription_count() == 1)
        return publisher

    def publisher(self, kind, topic):
        return self.ready(self.robot.create_publisher(kind, topic, 10))

    def header(self, frame='base_link'):
        return Header(stamp=self.robot.get_clock().now().to_msg(), frame_id=frame)

    def command(self, forward):
        twist = Twist()
        twist.linear.x = forward
        self.commands.publish(twist if self.commands.msg_type is Twist else TwistStamped(twist=twist))

    def drives(self, send, until, seconds=20.0):
        """Send measurements and commands until a velocity satisfies a condition; return the last state."""

        def step():
            send()
            self.command(0.3)
            self.graph.spin_until(lambda: False, 0.1)
            return bool(self.velocities) and until(self.velocities[-1])

        assert self.graph.spin_until(step, seconds)
        known = len(self.states)
        assert self.graph.spin_until(lambda: len(self.states) > known + 1)
        return json.loads(self.states[-1].data)


def forward(message):
    return message.linear.x if isinstance(message, Twist) else message.twist.linear.x


def is_free(message):
    return forward(message) == 0.3


def is_zero(message):
    return forward(message) == 0.0


def test_a_cloud_stops_the_robot_and_its_silence_too(graph):
    robot = Robot(graph)
    cloud = robot.publisher(PointCloud2, 'points')
    robot.drives(lambda: cloud.publish(cloud_from_points(FAR, robot.header())), is_free)
    assert robot.drives(lambda: None, is_zero)['reason'].startswith('front: no new message')
    robot.drives(lambda: cloud.publish(cloud_from_points(FAR, robot.header())), is_free)
    near = WALL - np.float32([0.14, 0.0, 0.0])
    state = robot.drives(lambda: cloud.publish(cloud_from_points(near, robot.header())), is_zero)
    assert (state['action'], state['source']) == ('stop', 'front')
    assert robot.zones[-1].header.frame_id == 'base_link'
    assert len(robot.zones[-1].polygon.points) > 8
    robot.drives(lambda: cloud.publish(cloud_from_points(FAR, robot.header())), is_free)
    wrong = robot.drives(lambda: cloud.publish(cloud_from_points(FAR, robot.header(''))), is_zero)
    assert 'is in another frame' in wrong['reason']


def test_a_scan_and_a_depth_image_with_plain_twists(graph):
    sources = {'sources': ['scan', 'depth'], 'stamped': False, 'scan.type': 'scan', 'depth.type': 'depth'}
    robot = Robot(graph, Twist, **sources, **{'depth.topic': 'camera/depth', 'scan.topic': 'laser'})
    scans, images = robot.publisher(LaserScan, 'laser'), robot.publisher(Image, 'camera/depth')
    infos = robot.publisher(CameraInfo, 'camera/camera_info')
    p = [30.0, 0.0, 19.5, 0.0, 0.0, 30.0, 14.5, 0.0, 0.0, 0.0, 1.0, 0.0]
    k = [30.0, 0.0, 19.5, 0.0, 30.0, 14.5, 0.0, 0.0, 1.0]

    def send(distance=4.0, range_m=math.inf):
        scans.publish(LaserScan(header=robot.header('laser'), angle_min=-0.5, angle_max=0.5, angle_increment=0.01,
                                range_min=0.05, range_max=8.0, ranges=[range_m] * 101))  # fmt: skip
        infos.publish(CameraInfo(header=robot.header('optical'), width=40, height=30, k=k, p=p))
        depth = np.full((30, 40), distance, np.float32)
        images.publish(Image(header=robot.header('optical'), width=40, height=30, encoding='32FC1', step=160,
                             data=array('B', depth.tobytes())))  # fmt: skip

    robot.drives(send, is_free)
    assert robot.drives(lambda: send(range_m=0.22), is_zero)['source'] == 'scan'
    robot.drives(send, is_free)
    assert robot.drives(lambda: send(distance=0.22), is_zero)['source'] == 'depth'


@pytest.mark.parametrize(
    ('parameter', 'text'),
    [
        ('sources:=[front, front]', 'different names'),
        ('sources:=[Front]', 'lower-case'),
        ('front.height_min:=2.0', 'height_min is not below'),
        ('footprint:=[1.0, 2.0]', 'three or more corners'),
        ('latency:=-1.0', 'latency'),
    ],
)
def test_a_bad_parameter_ends_the_start_in_one_line(parameter, text, capsys):
    assert run_in_process(main, '--ros-args', '-p', parameter) == 1
    error = capsys.readouterr().err
    assert text in error
    assert error.count('\n') == 1
