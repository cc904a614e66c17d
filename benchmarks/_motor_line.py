"""The bridge on pseudo-terminals in real time: disconnected, killed, suspended; and its latency to the wire."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from threading import Lock

import numpy as np
from _figures import Figure, count, measured, rate
from _figures import time as times_of
from geometry_msgs.msg import TwistStamped
from node_testing import IsolatedGraph, isolated_graph
from rclpy.node import Node
from rclpy.publisher import Publisher

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.emulator_settings import EmulatorSettings
from motor_bridge.emulator.line_faults import FaultRequest, LineFaults
from motor_bridge.emulator.pseudo_terminal import PseudoTerminal, RealTimeStepper
from motor_bridge.node import MotorBridgeNode

AUTO_STOP = EmulatorSettings().auto_stop
Rows = list[tuple[str, Figure]]


class Driver:
    """Node that publishes velocities to a bridge."""

    def __init__(self, graph: IsolatedGraph) -> None:
        self._graph = graph
        self.node = graph.add(lambda **options: Node('driver', **options))
        self._velocities: Publisher = self.node.create_publisher(TwistStamped, 'cmd_vel', 10)

    def wait_for_bridge(self, is_there: bool = True) -> None:
        self._graph.spin_until(lambda: bool(self._velocities.get_subscription_count()) == is_there, 30.0)

    def send(self, forward: float) -> None:
        message = TwistStamped()
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.twist.linear.x = forward
        self._velocities.publish(message)

    def drive(self, seconds: float, forward: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.send(forward)
            self._graph.spin_until(lambda: False, 0.02)


def disconnect_terminal(disconnections: int) -> Rows:
    """Disconnect the terminal repeatedly while the robot drives to and fro."""
    robot = EmulatorSettings(slip_sigma=0.0)
    controller, lock = EmulatedController(robot, np.random.default_rng(1)), Lock()
    faults, rng = LineFaults(np.random.default_rng(2)), np.random.default_rng(3)
    with tempfile.TemporaryDirectory() as folder, isolated_graph() as graph:
        link = Path(folder) / 'tty'
        with PseudoTerminal(controller, lock, faults=faults, link=link), RealTimeStepper(controller, lock):
            bridge = graph.add(MotorBridgeNode, port=str(link))
            driver, session = Driver(graph), bridge._session  # noqa: SLF001 the truth of the inside
            driver.wait_for_bridge()
            graph.spin_until(lambda: session.report.is_connected)
            driver.drive(6.0, 0.3)  # where the encoders are not near 0, as they are after a reset
            reconnected, worst = 0, 0.0
            for disconnection in range(disconnections):
                driver.drive(0.5, 0.3 if disconnection % 2 else -0.3)
                before = session.report.connections
                faults.inject(FaultRequest('unplug', float(rng.uniform(0.05, 0.5))))
                reconnected += graph.spin_until(lambda n=before: session.report.connections > n, 10.0)  # type: ignore[misc]
                graph.spin_until(lambda: controller.is_stopped, 3.0)
                graph.spin_until(lambda: False, 0.15)
                with session.lock, lock:
                    odometry_pose = session.odometry.state.T_odom_base
                    worst = max(worst, odometry_pose.distance_to(controller.T_world_base))
            restarts = sum(
                n for status, n in session.odometry.status_counts.items() if status.name == 'RESTARTED'
            )
            bridge.stop()
    return [
        ('disconnections after which the bridge reconnected', rate(reconnected, disconnections)),
        ('of these odometry detected an encoder reset', rate(restarts, disconnections, 'lower')),
        ('greatest error of odometry after any of them', measured(1e3 * worst, '.1f', ' mm')),
    ]


@contextmanager
def _start_process(*command: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, *command],
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGCONT)
        process.terminate()
        process.wait(10.0)


@contextmanager
def _logged_controller(link: Path, log: Path) -> Iterator[subprocess.Popen[str]]:
    script = str(Path(__file__).with_name('_logged_controller.py'))
    with _start_process(script, str(link), str(log)) as process:
        if process.stdout is not None:
            process.stdout.readline()
        yield process


def _events(log: Path, since: float) -> list[tuple[float, str]]:
    rows = (line.split(' ', 1) for line in log.read_text().splitlines())
    return [(float(at), text) for at, text in rows if float(at) >= since]


@contextmanager
def _bridge(graph: IsolatedGraph, link: Path, *parameters: str) -> Iterator[subprocess.Popen[str]]:
    given = [word for each in (f'port:={link}', *parameters) for word in ('-p', each)]
    arguments = ['-m', 'motor_bridge.node', '--ros-args', *given]
    with _start_process(*arguments, ROS_DOMAIN_ID=str(graph.context.get_domain_id())) as process:
        yield process


def wire_latency(commands: int) -> Rows:
    """Measure the time from publishing a velocity to its bytes at the other end of the terminal, in three processes."""
    limits = 'max_linear_acceleration:=20.0', 'max_linear_jerk:=1000.0'
    sent, rng = [], np.random.default_rng(4)
    with tempfile.TemporaryDirectory() as folder, isolated_graph() as graph:
        link, log = Path(folder) / 'tty', Path(folder) / 'log'
        driver = Driver(graph)
        with _logged_controller(link, log), _bridge(graph, link, *limits):
            driver.wait_for_bridge()
            driver.drive(1.0, 0.4)
            for number in range(commands):
                time.sleep(float(rng.uniform(0.1, 0.15)))
                sent.append(time.monotonic())
                driver.send(0.1 + 0.3 * (number % 2))
            time.sleep(0.3)
        motions = [(at, text) for at, text in _events(log, 0.0) if text.startswith('m ')]
    changes = [now[0] for before, now in pairwise(motions) if now[1] != before[1]]
    times = [min((at - start for at in changes if at > start), default=np.inf) for start in sent]
    return [('from cmd_vel to the wire ms, median / 95 %', times_of(1e3 * np.array(times)))]


def kill_bridge(times: int) -> Rows:
    """Kill the bridge's process while it drives; see when the wheels stand."""
    offs: list[float] = []
    stops: list[float] = []
    with tempfile.TemporaryDirectory() as folder, isolated_graph() as graph:
        link, log = Path(folder) / 'tty', Path(folder) / 'log'
        driver = Driver(graph)
        with _logged_controller(link, log):
            for _ in range(times):
                with _bridge(graph, link) as bridge:
                    driver.wait_for_bridge()
                    driver.drive(2.5, 0.3)
                    killed = time.monotonic()
                    bridge.kill()
                    driver.drive(AUTO_STOP + 1.0, 0.3)
                events = _events(log, killed)
                for words, found in ((('coasts', 'stopped'), offs), (('stopped',), stops)):
                    found.append(min((at - killed for at, text in events if text in words), default=np.inf))
                driver.wait_for_bridge(is_there=False)
    return [
        (
            f'killed bridge: until the motors were off (auto-stop {AUTO_STOP:g} s)',
            measured(max(offs), '.2f', ' s'),
        ),
        ('until the wheels had rolled out, longest', measured(max(stops), '.2f', ' s')),
    ]


def suspend_controller(times: int) -> Rows:
    """Hold the controller's process with SIGSTOP while it drives, and let it go; see what it then does."""
    acted, first_is_stop = [], 0
    with tempfile.TemporaryDirectory() as folder, isolated_graph() as graph:
        link, log = Path(folder) / 'tty', Path(folder) / 'log'
        with _logged_controller(link, log) as process:
            bridge = graph.add(MotorBridgeNode, port=str(link))
            driver = Driver(graph)
            driver.wait_for_bridge()
            for _ in range(times):
                graph.spin_until(lambda: bridge._session.report.is_connected)  # noqa: SLF001
                driver.drive(1.5, 0.3)
                process.send_signal(signal.SIGSTOP)
                driver.drive(1.5, 0.3)
                resumed = time.monotonic()
                process.send_signal(signal.SIGCONT)
                driver.drive(0.3, 0.0)
                text = ''.join(text for _, text in _events(log, resumed))
                motions = [
                    c for c in text.replace('stopped', '').replace('moves', '').split(';') if c[:2] == 'm '
                ]
                before = motions.index('m 0 0') if 'm 0 0' in motions else len(motions)
                acted.append(before)
                first_is_stop += 'm 0 0' in motions and all(c == 'm 0 0' for c in motions[before:])
            bridge.stop()
    return [
        (
            'controller held for 1.5 s: motion commands before the stop, at most',
            count(max(acted), better='lower'),
        ),
        ('times nothing but stops followed', rate(first_is_stop, times)),
    ]
