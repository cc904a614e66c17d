"""A localizer's node in a process of its own, a listener, and bags that are played to both over Fast DDS."""

import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TypedDict

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from shirube_bags.errors import ReplayError
from shirube_bags.lockstep import NodeBarrier
from shirube_bags.stamps import NANOSECONDS
from shirube_bringup.free_domain import free_domain
from shirube_cli.project import CommandError, child_process, interrupt
from shirube_cli.workspace import find_executable, overlay_environment

# The node reads its map and compiles its kernels before it listens.
START_TIMEOUT = 120


class MessageInfo(TypedDict):
    """What the middleware says of a message: when it was published, by the clock of this machine [ns]."""

    source_timestamp: int


class PoseListener(Node):
    """Keeps what comes, by its stamp [ns].

    Attributes:
        localizer: name of the localizer's node.
        image_topic: topic of its images.
        images: when the image was published [ns].
        published: when the pose was published [ns].
        image_count: how many images came; more than ``images`` holds when a bag is played again.
        pose_count: how many poses came.
        delays: time between the publication of an image and of its pose [ns], one per pose.
        positions: position x, y, z of the pose [m].
        quaternions: orientation x, y, z, w of the pose.
        diagnostics: the latest values of the localizer's diagnostics.
        reports: how many diagnostics came.
    """

    def __init__(self, localizer: str, image_topic: str, context: Context) -> None:
        """Subscribe to the images and to the output of the localizer's node."""
        super().__init__('pose_listener', context=context)
        self.images: dict[int, int] = {}
        self.published: dict[int, int] = {}
        self.image_count = 0
        self.pose_count = 0
        self.delays: list[int] = []
        # An image and its pose come on two topics, either may be first.
        self._waiting: dict[int, int] = {}
        self._early: dict[int, int] = {}
        self._latest = 0
        self.positions: dict[int, tuple[float, float, float]] = {}
        self.quaternions: dict[int, tuple[float, float, float, float]] = {}
        self.diagnostics: dict[str, str] = {}
        self.reports = 0
        self.localizer = localizer
        self.image_topic = image_topic
        lossless = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
        self.create_subscription(CompressedImage, image_topic, self._take_image, lossless)
        self._poses = self.create_subscription(PoseStamped, f'/{localizer}/pose', self._take_pose, lossless)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._take_diagnostics, lossless)

    def sees_localizer(self) -> bool:
        """Return whether the subscription has found the publisher of the poses."""
        return int(self._poses.get_publisher_count()) > 0

    def reasons(self) -> dict[str, int]:
        """Return how many images had no pose for which reason, in the node's words."""
        prefix = 'images without: '
        return {
            key.removeprefix(prefix): int(value) for key, value in self.diagnostics.items() if key.startswith(prefix)
        }

    def _take_image(self, message: CompressedImage, info: MessageInfo) -> None:
        stamp, sent = _stamp(message.header), info['source_timestamp']
        self.images[stamp] = sent
        self.image_count += 1
        published = self._early.pop(stamp, None)
        if stamp < self._latest:
            # The bag begins again: what waits belongs to the round before.
            self._waiting.clear()
            self._early.clear()
        self._latest = stamp
        if published is None:
            self._waiting[stamp] = sent
        else:
            self.delays.append(published - sent)

    def _take_pose(self, message: PoseStamped, info: MessageInfo) -> None:
        stamp, p, q = _stamp(message.header), message.pose.position, message.pose.orientation
        self.published[stamp] = info['source_timestamp']
        self.pose_count += 1
        sent = self._waiting.pop(stamp, None)
        if sent is None:
            self._early[stamp] = self.published[stamp]
        else:
            self.delays.append(self.published[stamp] - sent)
        self.positions[stamp] = (p.x, p.y, p.z)
        self.quaternions[stamp] = (q.x, q.y, q.z, q.w)

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.startswith(self.localizer):
                self.diagnostics = {pair.key: pair.value for pair in status.values}
                self.reports += 1


def _stamp(header: Header) -> int:
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


@dataclass(frozen=True)
class LiveLocalizer:
    """A running node with the environment of processes that exchange messages with it, its log, and its
    listener.
    """

    root: Path
    listener: PoseListener
    executor: SingleThreadedExecutor
    process: subprocess.Popen[bytes]
    environment: dict[str, str]
    log: Path

    def play(self, bag: Path, options: list[str], on_turn: Callable[[], None] = lambda: None) -> None:
        """Play a bag to the node with more options of ``play``, and listen until it has been played.

        ``on_turn`` is called ten times a second or more. Raises a CommandError if the node or the player failed.
        """
        command = [*find_executable(self.root, 'shirube_bags', 'play'), str(bag), *options]
        command += ['--wait-for', f'{self.listener.image_topic}/2', '--timeout', str(START_TIMEOUT)]
        with child_process(command, self.environment, None) as playing:
            while playing.poll() is None:
                self.executor.spin_once(timeout_sec=0.1)
                self.check_alive()
                on_turn()
        if playing.returncode:
            raise CommandError(f'the player ended with exit code {playing.returncode}; see its message above')

    def listen_for_diagnostics(self) -> None:
        """Listen until the diagnostics, which come once a second, include the last image."""
        wanted, end = self.listener.reports + 2, monotonic() + 5.0
        while self.listener.reports < wanted and monotonic() < end:
            self.executor.spin_once(timeout_sec=0.1)

    def wait_for_connection(self) -> None:
        """Wait until the localizer's publisher and our subscription have discovered each other.

        Discovery may take seconds, in one direction before the other, and a pose published before that is lost.
        A reply of the node shows that its side is ready: endpoints are announced in the order of their creation,
        and the service client, which the node must know to reply, was created last.

        Raises:
            CommandError: the node ended, or did not reply in time.
        """
        end = monotonic() + START_TIMEOUT

        def has_ended() -> bool:
            return self.process.poll() is not None or monotonic() > end

        while not self.listener.sees_localizer() and not has_ended():
            self.executor.spin_once(timeout_sec=0.1)
        try:
            NodeBarrier(self.listener, self.executor, has_ended).wait_for_nodes(
                [f'/{self.listener.localizer}'], START_TIMEOUT
            )
        except ReplayError as fault:
            raise CommandError(f'{fault}; its log is {self.log}') from fault
        self.check_alive()
        if monotonic() > end:
            raise CommandError(f'the node was not heard within {START_TIMEOUT} s; see {self.log}')

    def check_alive(self) -> None:
        """Raise a CommandError that names the log if the node has ended."""
        if self.process.poll() is not None:
            raise CommandError(f'the node ended with exit code {self.process.returncode}; see {self.log}')

    def end(self) -> None:
        """End the node as Ctrl-C does; raise a CommandError that names the log if its exit code is not 0."""
        if code := interrupt(self.process):
            raise CommandError(f'the node ended with exit code {code}; see {self.log}')


@contextmanager
def live_localizer(
    root: Path, package: str, image_topic: str, folder: Path, node_command: list[str] | None = None
) -> Iterator[LiveLocalizer]:
    """Start a package's node, named as the package and by default the installed one, and listen to it.

    It runs in a domain that nobody else on this machine uses; logs go to the folder.
    """
    if node_command is None:
        node_command = find_executable(root, package, 'node')
    log = folder / 'node.log'
    with _listening(package, image_topic) as (listener, executor, domain):
        environment = {**overlay_environment(root), 'ROS_DOMAIN_ID': str(domain), 'ROS_LOG_DIR': str(folder / 'log')}
        with child_process(node_command, environment, log) as process:
            live = LiveLocalizer(root, listener, executor, process, environment, log)
            live.wait_for_connection()
            yield live


@contextmanager
def _listening(package: str, image_topic: str) -> Iterator[tuple[PoseListener, SingleThreadedExecutor, int]]:
    """Give a listener on the loopback only, and the number of its domain."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    context = rclpy.Context()
    with free_domain() as domain:
        rclpy.init(context=context, domain_id=domain)
        listener = PoseListener(package, image_topic, context)
        # Not node_executor's: rclpy's EventsExecutor fails at callbacks that ask when a message was sent.
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(listener)
        try:
            yield listener, executor, domain
        finally:
            executor.shutdown()
            listener.destroy_node()
            context.try_shutdown()
