"""Nodes within the process of a test: an isolated ROS graph, main functions that fail to start, bags for them."""

import os
import signal
import sys
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from time import monotonic
from typing import Any, TypeVar

import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header, String

from shirube_bags.bag_reader import BagReader
from shirube_bags.bag_writer import BagWriter
from shirube_bags.lockstep import replay_in_lockstep
from shirube_bags.trajectory_files import header_stamp
from shirube_bringup.free_domain import free_domain
from shirube_core.geometry import SE2
from shirube_ros.managed_node import ManagedNode
from shirube_ros.message_conversion import planar_pose
from shirube_ros.node import node_executor
from shirube_ros.quality_of_service import pose_profile

TRUTH = '/ground_truth'

AnyNode = TypeVar('AnyNode', bound=Node)


class IsolatedGraph:
    """Nodes that discover only each other."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self.executor = node_executor(context)
        self._nodes: list[Node] = []

    def add(self, create_node: Callable[..., AnyNode], **parameters: object) -> AnyNode:
        """Create a node in this graph, spun by ``spin_until``.

        Args:
            create_node: node class, or function that passes its keywords on to ``rclpy.node.Node``.
            parameters: parameter overrides, as from the command line.
        """
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        node = create_node(context=self.context, parameter_overrides=overrides)
        self._nodes.append(node)
        self.executor.add_node(node)
        return node

    def node(self, name: str, **options: object) -> Node:
        """Create a plain node in this graph."""
        return self.add(lambda **given: Node(name, **(given | options)))

    def spin_until(self, is_done: Callable[[], bool], timeout: float = 10.0) -> bool:
        """Spin until a condition is true; return False after ``timeout`` [s]."""
        end = monotonic() + timeout
        while not is_done():
            if monotonic() > end:
                return False
            self.executor.spin_once(timeout_sec=0.05)
        return True

    def close(self) -> None:
        """Destroy the nodes."""
        self.executor.shutdown()
        for node in self._nodes:
            node.destroy_node()


class NodeUser:
    """Publishes what a node subscribes to, and listens to what it publishes."""

    node: ManagedNode
    robot: Node
    publishers: dict[str, Publisher]
    reports: list[DiagnosticStatus]
    _graph: IsolatedGraph

    def wait_for(self, messages: list[Any], number: int = 1) -> None:
        """Wait until so many messages have arrived."""
        assert self._graph.spin_until(lambda: len(messages) >= number)

    def report(self) -> DiagnosticStatus:
        """Return the next status in the diagnostics."""
        self.wait_for(self.reports, len(self.reports) + 1)
        return self.reports[-1]

    def listen(self, kind: type, name: str) -> list[Any]:
        """Return the list to which messages of a topic below the node's name are appended."""
        received: list[Any] = []
        topic = f'{self.node.get_fully_qualified_name()}/{name}'
        self.robot.create_subscription(kind, topic, received.append, 10)
        assert self._graph.spin_until(lambda: self.node.count_subscribers(topic) == 1)
        return received

    def send(self, topic: str, message: Any) -> None:
        """Publish a message and wait until the node has received it."""
        guard = self.node._guard
        before = guard.counts[topic].received
        self.publishers[topic].publish(message)
        assert self._graph.spin_until(lambda: guard.counts[topic].received > before)


def header(stamp: float, frame: str = '') -> Header:
    """Return a header with a stamp [s]."""
    return Header(stamp=Time(sec=int(stamp), nanosec=round(stamp % 1.0 * 1e9)), frame_id=frame)


@contextmanager
def isolated_graph(domain: int | None = None) -> Iterator[IsolatedGraph]:
    """Open a graph on a domain, by default one that no other test on this host uses."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    context = Context()
    with free_domain() if domain is None else nullcontext(domain) as number:
        rclpy.init(context=context, domain_id=number)
        graph = IsolatedGraph(context)
        try:
            yield graph
        finally:
            graph.close()
            context.try_shutdown()


@pytest.fixture
def graph() -> Iterator[IsolatedGraph]:
    """Nodes that see only each other."""
    with isolated_graph() as opened:
        yield opened


def run_in_process(main: Callable[[], int], *arguments: str) -> int:
    """Call the main function of a node that fails to start.

    Args:
        main: main function of the node.
        arguments: command line arguments.

    Returns:
        exit code.
    """
    given = sys.argv
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    sys.argv = ['node', *arguments]
    try:
        return main()
    finally:
        sys.argv = given
        for number, handler in handlers.items():
            signal.signal(number, handler)


def cloud_from_points(points: NDArray[np.float32], header: Header) -> PointCloud2:
    """Return points, shape (n, 3) [m], as an unorganized cloud (one row)."""
    kind = PointField.FLOAT32
    return PointCloud2(
        header=header,
        height=1,
        width=len(points),
        fields=[PointField(name='xyz'[k], offset=4 * k, datatype=kind, count=1) for k in range(3)],
        point_step=12,
        row_step=12 * len(points),
        data=array('B', np.asarray(points, '<f4').tobytes()),
        is_dense=bool(np.isfinite(points).all()),
    )


def poses_in(bag: BagReader, topic: str) -> dict[int, SE2]:
    """Return the poses of a topic by their stamps [ns]."""
    messages = bag.messages([topic])
    return {header_stamp(raw.raw): planar_pose(bag.decode(raw).pose, topic) for raw in messages}


def first_seconds(path: Path, seconds: float, source: Path, keep: Callable[[float], bool] = lambda _: True) -> Path:
    """Copy the beginning of a bag, messages at times that are kept [s]."""
    with BagReader(source) as bag, BagWriter(path) as copy:
        for raw in bag.messages():
            if raw.stamp_ns > bag.start_ns + 1e9 * seconds:
                break
            if keep(1e-9 * (raw.stamp_ns - bag.start_ns)):
                copy.write_raw(raw.topic, raw.msgtype, raw.raw, raw.stamp_ns)
    return path


def replay_live(
    create_node: Callable[..., Node], path: Path, **parameters: object
) -> tuple[NDArray[np.float64], int, list[str]]:
    """Replay a bag through a live localizer, whose images are compressed.

    Returns:
        errors of its poses [m], number of true poses, and the commands that it accepted.
    """
    poses: dict[int, SE2] = {}
    commands: list[str] = []

    def take_pose(message: PoseStamped) -> None:
        stamp = message.header.stamp
        poses[stamp.sec * 1_000_000_000 + stamp.nanosec] = planar_pose(message.pose, 'pose')

    with isolated_graph() as graph, BagReader(path) as bag:
        node = graph.add(create_node, use_sim_time=True, image_transport='compressed', **parameters)
        player, name, profile = graph.node('player'), node.get_fully_qualified_name(), pose_profile()
        player.create_subscription(PoseStamped, f'{name}/pose', take_pose, profile)
        player.create_subscription(String, f'{name}/command', lambda m: commands.append(m.data), profile)
        replay_in_lockstep(bag, player, graph.executor, [topic for topic in bag.topics if topic != TRUTH])
        graph.spin_until(lambda: False, timeout=0.2)
        truth = poses_in(bag, TRUTH)
    errors = [pose.distance_to(truth[stamp]) for stamp, pose in poses.items()]
    return np.array(errors), len(truth), commands
