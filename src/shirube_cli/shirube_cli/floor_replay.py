"""Replays a recorded drive through the live floor localizer: processes of their own, joined by Fast DDS."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import numpy as np
import rclpy
from domain_coordinator import domain_id
from numpy.typing import NDArray
from rclpy.executors import SingleThreadedExecutor

from shirube_bags.errors import ReplayError
from shirube_bags.node_questions import NodeQuestions
from shirube_bags.stamps import NANOSECONDS
from shirube_bags.trajectory import Trajectory, make_trajectory
from shirube_cli.child_process import child_process, interrupt
from shirube_cli.error import CommandError
from shirube_cli.pose_listener import PoseListener
from shirube_cli.workspace import find_executable, overlay_environment

LOCALIZER = 'floor_localizer'
IMAGES = '/image_raw/compressed'
# The node reads its map and compiles its loops before it listens.
START_TIMEOUT = 120


@dataclass(frozen=True)
class FloorReplay:
    """What came of a replay.

    Attributes:
        trajectory: the poses that the node published.
        images: how many images were replayed.
        delays: array, shape (n,), from the publication of an image to that of its pose [s].
        duration: wall time from the first image to the last pose [s].
        reasons: how many images had no pose for which reason, in the node's words.
    """

    trajectory: Trajectory
    images: int
    delays: NDArray[np.float64]
    duration: float
    reasons: dict[str, int]


def replay_floor_drive(
    root: Path, bag: Path, folder: Path, node_command: list[str] | None = None
) -> FloorReplay:
    """Replay the bag as fast as the node keeps up and return what the node made of it.

    Args:
        root: the repository, its workspace built.
        bag: the recorded drive.
        folder: takes the logs.
        node_command: program and arguments of the localizer; by default the installed node, without any.

    Raises:
        CommandError: a process failed, or no pose came; the message names the log.
    """
    if node_command is None:
        node_command = [sys.executable, str(find_executable(root, LOCALIZER, 'node'))]
    player = [sys.executable, str(find_executable(root, 'shirube_bags', 'play')), str(bag), '--rate', '0']
    player += ['--wait-for', f'{IMAGES}/2', '--timeout', str(START_TIMEOUT)]
    log = folder / 'node.log'
    with _listening() as (listener, executor, domain):
        environment = {
            **overlay_environment(root),
            'ROS_DOMAIN_ID': str(domain),
            'ROS_LOG_DIR': str(folder / 'log'),
        }
        with child_process(node_command, environment, log) as node:
            _spin_until_heard(executor, listener, node, log)
            with child_process(player, environment, None) as playing:
                _spin_until_ended(executor, playing, node, log)
            _spin_for_diagnostics(executor, listener)
            code = interrupt(node)
    if code:
        raise CommandError(f'the node ended with exit code {code}; see {log}')
    if not listener.published:
        raise CommandError(f'the node published no pose; see {log}')
    return _sum_up(listener)


@contextmanager
def _listening() -> Iterator[tuple[PoseListener, SingleThreadedExecutor, int]]:
    """Give a listener in a domain that nobody else on this machine uses, on the loopback only."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    context = rclpy.Context()
    with domain_id() as domain:
        rclpy.init(context=context, domain_id=domain)
        listener = PoseListener(LOCALIZER, IMAGES, context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(listener)
        try:
            yield listener, executor, domain
        finally:
            executor.shutdown()
            listener.destroy_node()
            context.try_shutdown()


def _spin_until_heard(
    executor: SingleThreadedExecutor, listener: PoseListener, node: subprocess.Popen[bytes], log: Path
) -> None:
    """Listen until no pose of the localizer can get lost any more.

    Two nodes that start together may find each other's topics seconds apart, one direction before the other,
    and a pose published before that is gone. The listener's subscription sees the node's publisher; that the
    publisher sees the subscription, too, shows in an answer of the node: endpoints are announced in the order
    in which they were made, and the asker's, which must be known to get an answer, was made last.

    Raises:
        CommandError: the node ended, or was not heard in time.
    """
    end = monotonic() + START_TIMEOUT

    def has_ended() -> bool:
        return node.poll() is not None or monotonic() > end

    while not listener.sees_localizer() and not has_ended():
        executor.spin_once(timeout_sec=0.1)
    try:
        NodeQuestions(listener, executor, has_ended).ask([f'/{LOCALIZER}'], START_TIMEOUT)
    except ReplayError as fault:
        raise CommandError(f'{fault}; its log is {log}') from fault
    if node.poll() is not None:
        raise CommandError(f'the node ended with exit code {node.returncode}; see {log}')
    if monotonic() > end:
        raise CommandError(f'the node was not heard within {START_TIMEOUT} s; see {log}')


def _spin_until_ended(
    executor: SingleThreadedExecutor,
    playing: subprocess.Popen[bytes],
    node: subprocess.Popen[bytes],
    log: Path,
) -> None:
    """Listen until the bag has been played.

    Raises:
        CommandError: the node or the player ended with an error.
    """
    while playing.poll() is None:
        executor.spin_once(timeout_sec=0.1)
        if node.poll() is not None:
            raise CommandError(f'the node ended with exit code {node.returncode}; see {log}')
    if playing.returncode:
        raise CommandError(f'the player ended with exit code {playing.returncode}; its message stands above')


def _spin_for_diagnostics(executor: SingleThreadedExecutor, listener: PoseListener) -> None:
    """Listen until the diagnostics, which come once a second, tell of the last image."""
    wanted, end = listener.reports + 2, monotonic() + 5.0
    while listener.reports < wanted and monotonic() < end:
        executor.spin_once(timeout_sec=0.1)


def _sum_up(listener: PoseListener) -> FloorReplay:
    stamps = sorted(listener.published)
    answered = [stamp for stamp in stamps if stamp in listener.images]
    delays = [listener.published[stamp] - listener.images[stamp] for stamp in answered]
    times = [*listener.images.values(), *listener.published.values()]
    prefix = 'images without: '
    reasons = {
        key.removeprefix(prefix): int(value)
        for key, value in listener.diagnostics.items()
        if key.startswith(prefix)
    }
    return FloorReplay(
        trajectory=make_trajectory(
            stamps,
            [listener.positions[stamp] for stamp in stamps],
            [listener.quaternions[stamp] for stamp in stamps],
        ),
        images=len(listener.images),
        delays=np.array(delays) / NANOSECONDS,
        duration=(max(times) - min(times)) / NANOSECONDS,
        reasons=reasons,
    )
