"""The node in an isolated graph, with an emulated controller on a pseudo-terminal."""

import time
from contextlib import ExitStack
from dataclasses import replace
from threading import Lock

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from motor_bridge.emulator.emulated_controller import EmulatedController
from motor_bridge.emulator.firmware import EmulatorSettings
from motor_bridge.emulator.pseudo_terminal import FaultRequest, LineFaults, PseudoTerminal, RealTimeStepper
from motor_bridge.node import MotorBridgeNode
from shirube_ros.message_conversion import planar_pose

SETTINGS = EmulatorSettings(encoder_noise=0.3, slip_sigma=0.0, boot_time=0.3)


class Robot:
    """The node under test, its robot and a driver."""

    def __init__(self, graph, link, *, real_time=True, firmware=SETTINGS.firmware, faults=None, **parameters):
        self._graph, self._stack = graph, ExitStack()
        self._drives_by_twist = parameters.get('command_type') != 'joints'
        self.controller, self.lock = (
            EmulatedController(replace(SETTINGS, firmware=firmware), np.random.default_rng(1)),
            Lock(),
        )
        self.faults = LineFaults(np.random.default_rng(2))
        for fault in (faults or {}).items():
            self.fault(*fault)
        self.terminal = self._stack.enter_context(
            PseudoTerminal(self.controller, self.lock, faults=self.faults, link=link)
        )
        if real_time:
            self._stack.enter_context(RealTimeStepper(self.controller, self.lock))
        settings = {'port': str(link), 'state_dir': str(link.parent / 'state')} | parameters
        self.node = graph.add(MotorBridgeNode, **settings)
        self.person = graph.add(lambda **options: Node('person', **options))
        self.odometry, self.joints, self.reports = [], [], []
        listen = self.person.create_subscription
        listen(Odometry, 'odom', self.odometry.append, 10)
        listen(JointState, 'joint_states', self.joints.append, 10)
        listen(DiagnosticArray, '/diagnostics', lambda array: self.reports.extend(array.status), 10)
        self.velocities = self.person.create_publisher(TwistStamped, 'cmd_vel', 10)
        self.estop = self.person.create_publisher(Bool, 'estop', 10)

    def __enter__(self):
        assert self._graph.spin_until(
            lambda: (
                self.estop.get_subscription_count() == 1
                and self.velocities.get_subscription_count() == self._drives_by_twist
            )
        )
        return self

    def __exit__(self, *_):
        self.node.stop()
        self._stack.close()

    @property
    def report(self):
        return self.node._session.report

    def until(self, is_done, timeout=10.0):
        assert self._graph.spin_until(is_done, timeout)

    def wait(self, seconds):
        self._graph.spin_until(lambda: False, seconds)

    def send(self, forward, turn=0.0, stamp=None):
        message = TwistStamped()
        message.header.stamp = stamp or self.node.get_clock().now().to_msg()
        message.twist.linear.x, message.twist.angular.z = forward, turn
        self.velocities.publish(message)

    def drive(self, seconds, forward, turn=0.0):
        self._command = forward, turn
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.send(forward, turn)
            self.wait(0.05)

    def stop(self, is_on=True):
        self.estop.publish(Bool(data=is_on))

    def fault(self, kind, amount=1.0):
        self.faults.inject(FaultRequest(kind, amount))

    def message(self):
        before = len(self.reports)
        self.until(lambda: len(self.reports) > before)
        return self.reports[-1]

    def refusals(self, topic='cmd_vel'):
        return list(self.node._guard.counts[topic].rejected)

    def call(self, service):
        client = self.person.create_client(Trigger, f'/motor_bridge/{service}')
        self.until(client.service_is_ready)
        future = client.call_async(Trigger.Request())
        self.until(future.done)
        return future.result()

    def is_stopped(self):
        with self.lock:
            return self.controller.is_stopped

    def is_driving(self, patience=0.0, keep=lambda: None):
        """Whether the wheels turn, at once, or with the last command sent again for so long [s]."""
        end = time.monotonic() + patience
        while not (turns := self._wheels_turn()) and time.monotonic() < end:
            keep()
            self.send(*self._command)
            self.wait(0.05)
        return turns

    def _wheels_turn(self):
        with self.lock:
            return self.controller.wheel_speeds[0] > 1.0

    def settle(self):
        """Wait until the robot is stopped and odometry has noticed."""
        self.until(self.is_stopped)
        seen = len(self.odometry)
        self.until(lambda: len(self.odometry) > seen + 2 and self.odometry[-1].twist.twist.linear.x == 0.0)

    def error(self):
        """Position error of odometry when the robot is stopped [m]."""
        self.settle()
        pose = planar_pose(self.odometry[-1].pose.pose, 'odom')
        return pose.distance_to(self.controller.T_world_base)
