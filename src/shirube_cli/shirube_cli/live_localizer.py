"""A localizer's node in a process of its own, a listener, and bags that are played to both over Fast DDS."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic

import rclpy
from rclpy.executors import SingleThreadedExecutor

from shirube_bags.errors import ReplayError
from shirube_bags.node_barrier import NodeBarrier
from shirube_cli.child_process import child_process, interrupt
from shirube_cli.error import CommandError
from shirube_cli.pose_listener import PoseListener
from shirube_cli.workspace import find_executable, overlay_environment
from shirube_ros.free_domain import free_domain

# The node reads its map and compiles its kernels before it listens.
START_TIMEOUT = 120


@dataclass(frozen=True)
class LiveLocalizer:
    """A running node and its listener.

    Attributes:
        root: the repository, its workspace built.
        listener: stores what the node publishes.
        executor: spins the listener.
        process: the node's process.
        environment: variables of other processes that exchange messages with the node.
        log: takes what the node prints.
    """

    root: Path
    listener: PoseListener
    executor: SingleThreadedExecutor
    process: subprocess.Popen[bytes]
    environment: dict[str, str]
    log: Path

    def play(self, bag: Path, options: list[str], on_turn: Callable[[], None] = lambda: None) -> None:
        """Play a bag to the node and listen until it has been played.

        Args:
            bag: the bag.
            options: more options of ``play``.
            on_turn: called after each turn of the executor, ten times a second or more.

        Raises:
            CommandError: the node or the player ended with an error.
        """
        command = [
            sys.executable,
            str(find_executable(self.root, 'shirube_bags', 'play')),
            str(bag),
            *options,
        ]
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
        """Raise if the node has ended.

        Raises:
            CommandError: it has; the message names the log.
        """
        if self.process.poll() is not None:
            raise CommandError(f'the node ended with exit code {self.process.returncode}; see {self.log}')

    def end(self) -> None:
        """End the node as Ctrl-C does.

        Raises:
            CommandError: its exit code is not 0; the message names the log.
        """
        if code := interrupt(self.process):
            raise CommandError(f'the node ended with exit code {code}; see {self.log}')


@contextmanager
def live_localizer(
    root: Path, package: str, image_topic: str, folder: Path, node_command: list[str] | None = None
) -> Iterator[LiveLocalizer]:
    """Start a localizer's node and listen to it, in a domain that nobody else on this machine uses.

    Args:
        root: the repository, its workspace built.
        package: the localizer's package, which is its node's name, too.
        image_topic: topic of its images.
        folder: takes the logs.
        node_command: program and arguments of the node; by default the installed one, without any.

    Raises:
        CommandError: the node did not start; the message names the log.
    """
    if node_command is None:
        node_command = [sys.executable, str(find_executable(root, package, 'node'))]
    log = folder / 'node.log'
    with _listening(package, image_topic) as (listener, executor, domain):
        environment = {
            **overlay_environment(root),
            'ROS_DOMAIN_ID': str(domain),
            'ROS_LOG_DIR': str(folder / 'log'),
        }
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
