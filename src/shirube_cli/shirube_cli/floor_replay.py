"""Replays a recorded drive through the live floor localizer and compares it with the ground truth."""

import os
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TypedDict

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose, PoseStamped
from numpy.typing import NDArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from shirube_bags.accuracy import AccuracyReport, TrajectoryErrors, compare_trajectories, compute_coverage, make_report
from shirube_bags.bag_reader import BagReader
from shirube_bags.errors import ReplayError
from shirube_bags.lockstep import NodeBarrier
from shirube_bags.ros_session import RosSession, ros_session
from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import Trajectory, make_trajectory
from shirube_bags.trajectory_files import load_bag_trajectory, load_header_stamps
from shirube_bringup.free_domain import free_domain
from shirube_cli.project import CommandError, child_process, interrupt
from shirube_cli.workspace import find_executable, overlay_environment

LOCALIZER = 'floor_localizer'
IMAGES = '/image_raw/compressed'
# The node reads its map and compiles its kernels before it listens.
START_TIMEOUT = 120
_REASON = 'images without: '


class MessageInfo(TypedDict):
    """What the middleware says of a message: when it was published, by the clock of this machine [ns]."""

    source_timestamp: int


@dataclass(frozen=True)
class FloorReplay:
    """Result of a replay.

    Attributes:
        trajectory: the published poses.
        images: number of images.
        delays: delays from an image to its pose, shape (n,) [s].
        duration: wall time from the first image to the last pose [s].
        reasons: number of images without a pose, by the reason in the node's words.
    """

    trajectory: Trajectory
    images: int
    delays: NDArray[np.float64]
    duration: float
    reasons: dict[str, int]


class _LiveLocalizer:
    """The node in a process of its own, and what it and the player publish, by stamp [ns]."""

    def __init__(self, session: RosSession, process: subprocess.Popen[bytes], log: Path) -> None:
        """Subscribe to the images and to the output of the node."""
        self._session, self._process, self._log = session, process, log
        self._images: dict[int, int] = {}
        self._poses: dict[int, tuple[int, Pose]] = {}
        self._reasons: dict[str, int] = {}
        self._reports = 0
        lossless = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
        subscribe = session.node.create_subscription
        subscribe(CompressedImage, IMAGES, self._take_image, lossless)
        self._pose_topic = subscribe(PoseStamped, f'/{LOCALIZER}/pose', self._take_pose, lossless)
        subscribe(DiagnosticArray, '/diagnostics', self._take_diagnostics, lossless)

    def _take_image(self, message: CompressedImage, info: MessageInfo) -> None:
        self._images[_stamp(message.header)] = info['source_timestamp']

    def _take_pose(self, message: PoseStamped, info: MessageInfo) -> None:
        self._poses[_stamp(message.header)] = info['source_timestamp'], message.pose

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.startswith(LOCALIZER):
                values = {pair.key: pair.value for pair in status.values if pair.key.startswith(_REASON)}
                self._reasons = {key.removeprefix(_REASON): int(value) for key, value in values.items()}
                self._reports += 1

    def _listen_until(self, is_done: Callable[[], bool], seconds: float) -> None:
        """Listen until a condition holds or the time is over; raise a CommandError if the node has ended."""
        end = monotonic() + seconds
        while not is_done() and monotonic() < end:
            self._session.executor.spin_once(timeout_sec=0.1)
            if self._process.poll() is not None:
                raise CommandError(f'the node ended with exit code {self._process.returncode}; see {self._log}')

    def wait_for_connection(self) -> None:
        """Wait until the localizer's publisher and our subscription have discovered each other.

        Discovery may take seconds, in one direction before the other, and a pose published before that is lost.
        A reply of the node shows that its side is ready: endpoints are announced in the order of their creation,
        and the service client, which the node must know to reply, was created last.

        Raises:
            CommandError: the node ended, or did not reply in time.
        """
        self._listen_until(lambda: self._pose_topic.get_publisher_count() > 0, START_TIMEOUT)
        if not self._pose_topic.get_publisher_count():
            raise CommandError(f'the node was not heard within {START_TIMEOUT} s; see {self._log}')
        barrier = NodeBarrier(self._session.node, self._session.executor, lambda: self._process.poll() is not None)
        try:
            barrier.wait_for_nodes([f'/{LOCALIZER}'], START_TIMEOUT)
        except ReplayError as fault:
            raise CommandError(f'{fault}; its log is {self._log}') from fault

    def replay(self, player: list[str], environment: dict[str, str]) -> FloorReplay:
        """Run a player, listen until it and the diagnostics, which come once a second, include the last image."""
        with child_process(player, environment, None) as playing:
            self._listen_until(lambda: playing.poll() is not None, np.inf)
        if playing.returncode:
            raise CommandError(f'the player ended with exit code {playing.returncode}; see its message above')
        wanted = self._reports + 2
        self._listen_until(lambda: self._reports >= wanted, 5.0)
        if code := interrupt(self._process):
            raise CommandError(f'the node ended with exit code {code}; see {self._log}')
        if not self._poses:
            raise CommandError(f'the node published no pose; see {self._log}')
        return self._sum_up()

    def _sum_up(self) -> FloorReplay:
        stamps = sorted(self._poses)
        poses = [self._poses[stamp][1] for stamp in stamps]
        published = {stamp: time for stamp, (time, _) in self._poses.items()}
        times = [*self._images.values(), *published.values()]
        positions = [(p.position.x, p.position.y, p.position.z) for p in poses]
        quaternions = [(p.orientation.x, p.orientation.y, p.orientation.z, p.orientation.w) for p in poses]
        trajectory = make_trajectory(stamps, positions, quaternions)
        latencies = np.array([published[k] - self._images[k] for k in stamps if k in self._images]) / NANOSECONDS
        duration = (max(times) - min(times)) / NANOSECONDS
        return FloorReplay(trajectory, len(self._images), latencies, duration, self._reasons)


def _stamp(header: Header) -> int:
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def replay_floor_drive(root: Path, bag: Path, folder: Path, node_command: list[str] | None = None) -> FloorReplay:
    """Replay the bag as fast as the node keeps up, in a domain that nobody else on this machine uses.

    The node is the installed one without arguments, unless a command is given; logs go to the folder. Raises a
    CommandError if a process failed, or no pose came; the message names the log.
    """
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    player = [*find_executable(root, 'shirube_bags', 'play'), str(bag), '--rate', '0']
    player += ['--wait-for', f'{IMAGES}/2', '--timeout', str(START_TIMEOUT)]
    with free_domain() as domain, ros_session('pose_listener', [], domain=domain) as session:
        environment = {**overlay_environment(root), 'ROS_DOMAIN_ID': str(domain), 'ROS_LOG_DIR': str(folder / 'log')}
        log = folder / 'node.log'
        command = node_command or find_executable(root, LOCALIZER, 'node')
        with child_process(command, environment, log) as process:
            live = _LiveLocalizer(session, process, log)
            live.wait_for_connection()
            return live.replay(player, environment)


LONGEST_GAP = 0.5
STAMP_TOLERANCE_NS = 1_000_000


@dataclass(frozen=True)
class FloorAccuracy:
    """A replay and its truth: stamps of all images, shape (n,) [ns], first and last stamp of each stretch of
    hidden floor, shape (k, 2) [ns], and the errors of the poses with their report.
    """

    truth: Trajectory
    images_ns: NDArray[np.int64]
    dirty_ns: NDArray[np.int64]
    errors: TrajectoryErrors
    report: AccuracyReport


def measure_accuracy(replay: FloorReplay, bag_path: Path) -> FloorAccuracy:
    """Compare the replay's poses with the truth in the bag."""
    with BagReader(bag_path) as bag:
        truth = load_bag_trajectory(bag, '/ground_truth')
        images = load_header_stamps(bag, IMAGES)
        dirt = [(message.stamp_ns, bag.decode(message).data) for message in bag.messages(['/dirt'])]
    dirty = dirty_stretches(dirt)
    errors = compare_trajectories(replay.trajectory, truth, LONGEST_GAP)
    coverage = compute_coverage(images, replay.trajectory.stamps_ns, STAMP_TOLERANCE_NS, dirty)
    return FloorAccuracy(truth, images, dirty, errors, make_report(errors, coverage, 'the images'))


def dirty_stretches(dirt: list[tuple[int, bool]]) -> NDArray[np.int64]:
    """Return the first and last stamp [ns], shape (k, 2), of each run of images of hidden floor.

    Args:
        dirt: stamp [ns] of each image and whether dirt hides the floor in it, in the order of time.
    """
    stamps = np.array([stamp for stamp, _ in dirt], dtype=np.int64)
    hidden = np.array([False, *(is_hidden for _, is_hidden in dirt), False])
    starts = np.flatnonzero(~hidden[:-1] & hidden[1:])
    ends = np.flatnonzero(hidden[:-1] & ~hidden[1:]) - 1
    return np.column_stack([stamps[starts], stamps[ends]])
