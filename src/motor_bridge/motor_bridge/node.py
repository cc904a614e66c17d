"""The ROS node: velocity commands in, odometry out."""

from __future__ import annotations

import sys
from functools import partial
from time import monotonic
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Bool

from motor_bridge.bridge_report import bridge_status
from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_protocol import ControllerSetup
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, check_velocity
from motor_bridge.core.drive_settings import DriveSettings
from motor_bridge.core.encoder_odometry import EncoderOdometry
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.ros_arduino_bridge import RosArduinoBridge
from motor_bridge.link.controller_session import ControllerSession, LinkReport
from motor_bridge.link.motor_loop import MotorLoop
from motor_bridge.link.serial_port import SerialPort
from motor_bridge.node_settings import NodeSettings
from motor_bridge.odometry_publisher import OdometryPublisher
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.diagnostics import Status
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import pose_profile

AUTO_STOP_PERIODS = 3.0
"""Least auto-stop that is set in the controller, in periods of the update rate."""


class MotorBridgeNode(ManagedNode):
    """Drives a differential drive robot over a serial motor controller.

    =====================  =================  ========================================================================
    subscribed             type               use
    =====================  =================  ========================================================================
    ``cmd_vel``            TwistStamped       velocity command; Twist with ``stamped:=false``
    ``estop``              Bool               emergency stop: true stops at once until false is received
    =====================  =================  ========================================================================

    =====================  =================  ========================================================================
    published              type               when
    =====================  =================  ========================================================================
    ``odom``               Odometry           after each valid read of the encoders
    ``joint_states``       JointState         likewise
    ``/tf``                TFMessage          likewise, with ``publish_tf`` and if tf2_msgs is installed
    ``/diagnostics``       DiagnosticArray    once a second
    =====================  =================  ========================================================================

    Service (Trigger): ``~/reset_odometry`` sets the current pose to the origin.
    """

    SETTINGS = (NodeSettings, DriveSettings)
    ERRORS = (MotorBridgeError,)

    def __init__(self, **options: Any) -> None:
        """Declare the parameters, and start; options are those of ``rclpy.node.Node``.

        Raises:
            SettingsError: an invalid parameter.
            MotorBridgeError: contradictory parameters.
        """
        super().__init__('motor_bridge', **options)
        self._loop: MotorLoop | None = None
        self.start()

    def check_settings(self) -> None:
        """Raise a MotorBridgeError for contradictory parameters."""
        settings = self.settings(NodeSettings)
        if not settings.port:
            raise MotorBridgeError('port is empty; set it to the serial port of the motor controller')
        if settings.odom_frame == settings.base_frame:
            raise MotorBridgeError('odom_frame and base_frame are equal; give them different names')
        if settings.left_wheel_joint == settings.right_wheel_joint:
            raise MotorBridgeError(
                'left_wheel_joint and right_wheel_joint are equal; give them different names'
            )
        DiffDriveKinematics(self.settings(DriveSettings))

    def configure(self) -> None:
        """Subscribe to velocity commands."""
        self._settings, drive = self.settings(NodeSettings), self.settings(DriveSettings)
        self._timeout = drive.cmd_vel_timeout
        self._is_simulated = bool(self.get_parameter('use_sim_time').value)
        self._output = OdometryPublisher(self, self._settings)
        self._session = self._make_session(drive)
        self._subscribe()
        create_trigger_service(self, self._guard, '~/reset_odometry', self._reset_odometry)
        self.create_timer(1.0 / self._settings.update_rate, self._cycle)

    def activate(self) -> None:
        """Connect to the controller."""
        self._loop = self._make_loop()
        self._loop.start()

    def halt(self) -> None:
        """Stop the motors and close the port."""
        if self._loop is not None:
            self._loop.close()
            self._loop = None

    def apply_settings(self) -> None:
        """Use changed velocity limits from the next cycle on."""
        drive = self.settings(DriveSettings)
        with self._session.lock:
            self._session.drive.apply_settings(drive)
            self._session.odometry.motion_bounds.apply_settings(DiffDriveKinematics(drive), drive)
        self._timeout = drive.cmd_vel_timeout

    def _make_session(self, drive: DriveSettings) -> ControllerSession:
        kinematics = DiffDriveKinematics(drive)
        return ControllerSession(
            BaseDrive(kinematics, drive, 1.0 / self._settings.update_rate),
            EncoderOdometry(kinematics, drive),
            self._now,
            LinkReport(self._log_link_state),
            self._output.publish,
        )

    def _make_loop(self) -> MotorLoop:
        settings = self._settings
        open_line = partial(SerialPort, settings.port, settings.baud, settings.reply_timeout)
        auto_stop = max(settings.short_auto_stop, AUTO_STOP_PERIODS / settings.update_rate)
        protocol = partial(RosArduinoBridge, setup=ControllerSetup(settings.baud, settings.gains, auto_stop))
        return MotorLoop(open_line, protocol, self._session, self._now)

    def _subscribe(self) -> None:
        kind, take = (
            (TwistStamped, self._take_stamped) if self._settings.stamped else (Twist, self._take_twist)
        )
        self._cmd_vel_subscription = self.subscribe(kind, 'cmd_vel', take, pose_profile())
        self._inputs.add('cmd_vel', Need.COMMAND, remedy='change stamped')
        # An emergency stop also holds for the time after the node is activated.
        self.subscribe(Bool, 'estop', self._take_estop, pose_profile(), Need.REQUEST, while_inactive=True)

    def _cycle(self) -> None:
        if self._loop is not None:
            self._loop.cycle()

    def _now(self) -> float:
        """Return simulated time or a monotonic clock [s], so that setting the wall clock has no effect."""
        return self._ros_now() if self._is_simulated else monotonic()

    def _ros_now(self) -> float:
        return float(self.get_clock().now().nanoseconds * 1e-9)

    def _log_link_state(self, message: str, is_connected: bool) -> None:
        if is_connected:
            self.get_logger().info(f'{self._settings.port}: {message}')
        else:
            self.get_logger().warning(message)

    def _take_stamped(self, message: TwistStamped) -> None:
        stamp = float(message.header.stamp.sec + message.header.stamp.nanosec * 1e-9)
        if stamp > 0.0:  # 0 means now
            age = self._ros_now() - stamp
            if age > self._timeout:
                raise MotorBridgeError('cmd_vel is too old; synchronize the clocks or check the network')
            if age < -self._timeout:
                raise MotorBridgeError(
                    'cmd_vel has a stamp in the future; synchronize the clocks and set use_sim_time in both nodes'
                )
        self._take_twist(message.twist)

    def _take_twist(self, message: Twist) -> None:
        velocity = check_velocity(message.linear.x, message.angular.z)
        if self._publisher_count() > 1:
            raise MotorBridgeError('more than one node publishes cmd_vel, all are ignored; keep one of them')
        if self._loop is not None:
            self._loop.set_target(velocity)

    def _publisher_count(self) -> int:
        return int(self.count_publishers(self._cmd_vel_subscription.topic_name))

    def _take_estop(self, message: Bool) -> None:
        if self._loop is not None:
            self._loop.set_emergency_stop(is_on=message.data)
        else:
            self._session.drive.set_emergency_stop(is_on=message.data)

    def _reset_odometry(self) -> str:
        with self._session.lock:
            self._session.odometry.reset()
        return 'odometry reset to the origin'

    def status(self) -> Status:
        """Return the status of the serial link, the wheels and cmd_vel."""
        return bridge_status(self._session, self._now(), self._publisher_count())

    def destroy_node(self) -> None:
        """Stop the motors and destroy the node."""
        self.halt()
        super().destroy_node()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('motor_bridge', MotorBridgeNode)


if __name__ == '__main__':
    sys.exit(main())
