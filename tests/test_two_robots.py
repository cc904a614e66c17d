"""Two robots in one graph drive to a goal each: processes of the nodes, and emulated motor controllers."""

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from node_testing import IsolatedGraph, cloud_from_points, isolated_graph
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal, RealTimeStepper
from shirube_bringup.free_domain import free_domain
from shirube_bringup.nodes import NodeProcesses, NodeSetup, Value
from shirube_core.geometry import SE2, rotation_matrix
from shirube_ros.message_conversion import planar_pose, pose_stamped, pose_with_covariance_stamped

pytestmark = [pytest.mark.newest_set_only, pytest.mark.timeout(300)]

WALL = np.array([(x, y, z) for x in (3.0, -1.0) for y in np.arange(-2.0, 2.0, 0.04) for z in (0.2, 0.4, 0.6)])
SHARED = ('/rosout', '/parameter_events', '/diagnostics')


@dataclass
class Robot:
    """A robot, its localizer (the odometry) and its sensor (a cloud of two walls)."""

    name: str
    wheel_radius: float
    T_map_start: SE2
    goal: SE2
    lock: Lock = field(default_factory=Lock)
    frames: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        settings = EmulatorSettings(wheel_radius=self.wheel_radius)
        self.controller = EmulatedController(settings, np.random.default_rng(0))

    def nodes(self, port: str) -> list[NodeSetup]:
        """Return the nodes; nothing but their namespace and frame_prefix differs from those of a lone robot."""
        common: dict[str, Value] = {'use_sim_time': False, 'frame_prefix': f'{self.name}/'}
        radius: dict[str, Value] = {'port': port, 'wheel_radius': self.wheel_radius}
        drive: dict[str, Value] = {'drive': True, 'resolution': 0.1, 'map_timeout': 5.0, 'pose_timeout': 5.0}
        topics = {'pose': 'pose_arbiter/pose', 'command': 'vlc_beacon/command'}
        return [
            NodeSetup('motor_bridge', common | radius, {}, namespace=self.name),
            NodeSetup('pose_arbiter', common | {'sources': ['dots']}, {}, namespace=self.name),
            NodeSetup('reward_planner', common | drive, topics, namespace=self.name),
        ]

    def connect(self, node: Node) -> None:
        """Localize by the odometry."""
        dots, points, goal = (
            node.create_publisher(kind, f'/{self.name}/{topic}', 10)
            for kind, topic in (
                (PoseWithCovarianceStamped, 'dots/pose_with_covariance'),
                (PointCloud2, 'points'),
                (PoseStamped, 'goal_pose'),
            )
        )
        count = 0

        def localize(message: Odometry) -> None:
            nonlocal count
            count += 1
            self.frames |= {message.header.frame_id, message.child_frame_id}
            T_map_base = self.T_map_start @ planar_pose(message.pose.pose, 'odom')
            header = Header(stamp=message.header.stamp, frame_id='map')
            if count % 5 == 0:
                dots.publish(pose_with_covariance_stamped(T_map_base, np.diag([1e-4, 1e-4, 1e-4]), header))
                flat = (WALL[:, :2] + (self.T_map_start.x - T_map_base.x, -T_map_base.y)) @ rotation_matrix(
                    T_map_base.yaw
                )
                cloud = np.column_stack([flat, WALL[:, 2]]).astype(np.float32)
                header = Header(stamp=message.header.stamp, frame_id=f'{self.name}/base_link')
                points.publish(cloud_from_points(cloud, header))
            if count % 50 == 0 and goal.get_subscription_count() and not self.is_driving:
                goal.publish(pose_stamped(self.goal, Header(frame_id='map')))

        node.create_subscription(Odometry, f'/{self.name}/odom', localize, 10)

    @property
    def pose(self) -> SE2:
        """True pose in the map."""
        with self.lock:
            return self.T_map_start @ self.controller.T_world_base

    @property
    def is_driving(self) -> bool:
        return self.pose.distance_to(self.T_map_start) > 0.05

    @property
    def is_at_goal(self) -> bool:
        return self.pose.distance_to(self.goal) < 0.1


@pytest.fixture
def robots(tmp_path: Path) -> Iterator[tuple[list[Robot], IsolatedGraph]]:
    made = [
        Robot('robot1', 0.05, SE2(0.0, 0.0, 0.0), SE2(0.8, 0.0, 0.0)),
        Robot('robot2', 0.033, SE2(10.0, 0.0, 0.0), SE2(10.8, 0.2, 0.0)),
    ]
    with ExitStack() as stack:
        domain = stack.enter_context(free_domain())
        graph = stack.enter_context(isolated_graph(domain))
        nodes = []
        for robot in made:
            terminal = stack.enter_context(PseudoTerminal(robot.controller, robot.lock))
            stack.enter_context(RealTimeStepper(robot.controller, robot.lock))
            nodes += robot.nodes(str(terminal.path))
            robot.connect(graph.node(f'localizer_of_{robot.name}'))
        stack.enter_context(NodeProcesses(nodes, tmp_path, domain))
        yield made, graph


def test_each_robot_drives_to_its_goal_and_none_hears_the_other(robots: tuple[list[Robot], IsolatedGraph]) -> None:
    both, graph = robots
    assert graph.spin_until(lambda: all(robot.is_at_goal for robot in both), timeout=200.0), [
        robot.pose for robot in both
    ]
    watcher = graph.node('watcher')
    assert graph.spin_until(lambda: watcher.count_subscribers('/robot2/cmd_vel') > 0)
    nodes = {(name, namespace) for name, namespace in watcher.get_node_names_and_namespaces() if 'robot' in namespace}
    assert len(nodes) == 6
    for name, namespace in nodes:
        for listed in (
            watcher.get_subscriber_names_and_types_by_node,
            watcher.get_publisher_names_and_types_by_node,
            watcher.get_service_names_and_types_by_node,
        ):
            topics = {topic for topic, _ in listed(name, namespace)} - set(SHARED)
            assert all(topic.startswith(f'{namespace}/') for topic in topics), (name, topics)
    for robot in both:
        assert robot.frames == {f'{robot.name}/odom', f'{robot.name}/base_link'}
