"""The bridge on pseudo-terminals in real time: disconnected, killed, suspended; and its latency to the wire."""

import os
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

from motor_bridge.core.encoder_monitor import CountStatus
from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import FaultRequest, LineFaults, PseudoTerminal, RealTimeStepper
from motor_bridge.link.controller_session import ControllerSession
from motor_bridge.node import MotorBridgeNode
from motor_bridge.node_settings import NodeSettings
from shirube_cli.project import child_process

AUTO_STOPS = {'ros_arduino_bridge': EmulatorSettings().auto_stop, 'motor_controller': NodeSettings().short_auto_stop}
LATENCIES = (0.0, 0.0), (0.05, 0.05), (0.1, 0.1), (0.25, 0.0)  # latency and jitter of the line [s]
Rows = list[tuple[str, Figure]]


class LoggedController(EmulatedController):
    """Logs commands, when its motors get or lose voltage, and when its wheels stop, with their times [s]."""

    def __init__(self, firmware: str) -> None:
        super().__init__(EmulatorSettings(slip_sigma=0.0, firmware=firmware), np.random.default_rng(1))
        self.events: list[tuple[float, str]] = []

    def receive(self, data: bytes) -> bytes:
        """Log what is received."""
        self.events += [(time.monotonic(), word) for word in data.decode('ascii', 'replace').split('\r') if word]
        return super().receive(data)

    def advance(self, until: float) -> None:
        """Log changes of the motors."""
        before = self._state()
        super().advance(until)
        if self._state() != before:
            self.events.append((time.monotonic(), self._state()))

    def _state(self) -> str:
        if self.is_stopped:
            return 'stopped'
        return 'coasts' if self._firmware.pwm == (0, 0) else 'moves'

    def first_since(self, start: float, *words: str) -> float:
        """Return the time from a start until the first of some events [s]."""
        return min((at - start for at, word in self.events if at >= start and word in words), default=np.inf)


class Robot:
    """A logged controller on a pseudo-terminal, and a node that publishes velocities to its bridge."""

    def __init__(self, graph: IsolatedGraph, port: Path, firmware: str) -> None:
        self.controller, self.lock, self.port = LoggedController(firmware), Lock(), port
        self.faults = LineFaults(np.random.default_rng(2))
        self.graph = graph
        self._node = graph.add(lambda **options: Node('driver', **options))
        self._velocities: Publisher = self._node.create_publisher(TwistStamped, 'cmd_vel', 10)

    def wait_for_bridge(self, is_there: bool = True) -> None:
        self.graph.spin_until(lambda: bool(self._velocities.get_subscription_count()) == is_there, 30.0)

    def send(self, forward: float) -> None:
        message = TwistStamped()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.twist.linear.x = forward
        self._velocities.publish(message)

    def drive(self, seconds: float, forward: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.send(forward)
            self.graph.spin_until(lambda: False, 0.02)

    @contextmanager
    def own_bridge(self) -> Iterator[ControllerSession]:
        """Run the bridge in this process until the end of the block."""
        bridge = self.graph.add(MotorBridgeNode, port=str(self.port))
        session = bridge._session  # noqa: SLF001 the truth of the inside
        self.wait_for_bridge()
        yield session
        bridge.stop()

    @contextmanager
    def bridge(self, *parameters: str) -> Iterator[subprocess.Popen[bytes]]:
        """Run the bridge in a process of its own until the end of the block."""
        given = [word for each in (f'port:={self.port}', *parameters) for word in ('-p', each)]
        command = [sys.executable, '-m', 'motor_bridge.node', '--ros-args', *given]
        environment = os.environ | {'ROS_DOMAIN_ID': str(self.graph.context.get_domain_id())}
        with child_process(command, environment, None) as process:
            self.wait_for_bridge()
            yield process


@contextmanager
def served_robot(firmware: str = 'ros_arduino_bridge') -> Iterator[Robot]:
    """Serve a robot in real time until the end of the block."""
    with tempfile.TemporaryDirectory() as folder, isolated_graph() as graph:
        robot = Robot(graph, Path(folder) / 'tty', firmware)
        terminal = PseudoTerminal(robot.controller, robot.lock, faults=robot.faults, link=robot.port)
        with terminal, RealTimeStepper(robot.controller, robot.lock):
            yield robot


def disconnect_terminal(disconnections: int) -> Rows:
    """Disconnect the terminal repeatedly while the robot drives to and fro."""
    reconnected, worst, rng = 0, 0.0, np.random.default_rng(3)
    with served_robot() as robot, robot.own_bridge() as session:
        robot.graph.spin_until(lambda: session.report.is_connected)
        robot.drive(6.0, 0.3)  # where the encoders are not near 0, as they are after a reset
        for disconnection in range(disconnections):
            robot.drive(0.5, 0.3 if disconnection % 2 else -0.3)
            before = session.report.connections
            robot.faults.inject(FaultRequest('unplug', float(rng.uniform(0.05, 0.5))))
            reconnected += robot.graph.spin_until(lambda n=before: session.report.connections > n, 10.0)  # type: ignore[misc]
            robot.graph.spin_until(lambda: robot.controller.is_stopped, 3.0)
            robot.graph.spin_until(lambda: False, 0.15)
            with session.lock, robot.lock:
                found, true = session.odometry.state.T_odom_base, robot.controller.T_world_base
                worst = max(worst, found.distance_to(true))
        restarts = session.odometry.status_counts[CountStatus.RESTARTED]
    return [
        ('disconnections after which the bridge reconnected', rate(reconnected, disconnections)),
        ('of these odometry detected an encoder reset', rate(restarts, disconnections, 'lower')),
        ('greatest error of odometry after any of them', measured(1e3 * worst, '.1f', ' mm')),
    ]


def wire_latency(commands: int) -> Rows:
    """Measure the time from publishing a velocity to its bytes at the other end of the terminal, in two processes."""
    limits = 'max_linear_acceleration:=20.0', 'max_linear_jerk:=1000.0'
    sent, rng = [], np.random.default_rng(4)
    with served_robot() as robot, robot.bridge(*limits):
        robot.drive(1.0, 0.4)
        for number in range(commands):
            time.sleep(float(rng.uniform(0.1, 0.15)))
            sent.append(time.monotonic())
            robot.send(0.1 + 0.3 * (number % 2))
        time.sleep(0.3)
        motions = [event for event in robot.controller.events if event[1].startswith('m ')]
    changes = [now[0] for before, now in pairwise(motions) if now[1] != before[1]]
    times = [min((at - start for at in changes if at > start), default=np.inf) for start in sent]
    return [('from cmd_vel to the wire ms, median / 95 %', times_of(1e3 * np.array(times)))]


def connecting_time(times: int) -> Rows:
    """Measure the time from opening the port to the first counts on lines with latency and jitter."""
    rows: Rows = []
    for latency, jitter in LATENCIES:
        took = []
        with served_robot() as robot, robot.own_bridge() as session:
            for _ in range(times):
                for fault in (('latency', latency), ('jitter', jitter), ('unplug', 0.05)):
                    robot.faults.inject(FaultRequest(*fault))
                robot.graph.spin_until(lambda: not session.report.is_connected)
                start = time.monotonic()
                robot.graph.spin_until(lambda: session.report.is_connected, 20.0)
                took.append(time.monotonic() - start)
        name = f'latency {latency:g} s and up to {jitter:g} s more: until connected again, longest'
        rows.append((name, measured(max(took), '.2f', ' s')))
    return rows


def kill_bridge(times: int, firmware: str = 'ros_arduino_bridge') -> Rows:
    """Kill the bridge's process while it drives; see when the wheels stop."""
    offs: list[float] = []
    stops: list[float] = []
    auto_stop = AUTO_STOPS[firmware]
    with served_robot(firmware) as robot:
        for _ in range(times):
            with robot.bridge() as bridge:
                robot.drive(2.5, 0.3)
                killed = time.monotonic()
                bridge.kill()
                robot.drive(auto_stop + 1.0, 0.3)
            offs.append(robot.controller.first_since(killed, 'coasts', 'stopped'))
            stops.append(robot.controller.first_since(killed, 'stopped'))
            robot.wait_for_bridge(is_there=False)
    until_off = f'killed bridge: until the motors were off (auto-stop {auto_stop:g} s)'
    return [
        (until_off, measured(max(offs), '.2f', ' s')),
        (f'until the wheels had rolled out (auto-stop {auto_stop:g} s)', measured(max(stops), '.2f', ' s')),
    ]


def suspend_controller(times: int) -> Rows:
    """Suspend the controller while it drives, terminal and time, and resume it; see what it executes."""
    executed, only_stops = [], 0
    with served_robot() as robot, robot.own_bridge() as session:
        for _ in range(times):
            robot.graph.spin_until(lambda: session.report.is_connected)
            robot.drive(1.5, 0.3)
            with robot.lock:
                robot.drive(1.5, 0.3)
                resumed = time.monotonic()
            robot.drive(0.3, 0.0)
            motions = [word for at, word in robot.controller.events if at >= resumed and word[:2] == 'm ']
            before = motions.index('m 0 0') if 'm 0 0' in motions else len(motions)
            executed.append(before)
            only_stops += 'm 0 0' in motions and set(motions[before:]) == {'m 0 0'}
    name = 'controller held for 1.5 s: motion commands before the stop, at most'
    return [(name, count(max(executed), better='lower')), ('times nothing but stops followed', rate(only_stops, times))]
