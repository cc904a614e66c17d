"""The ROS node: velocity commands in, odometry out."""

import sys
from functools import partial
from time import monotonic
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy
from rclpy.subscription import Subscription
from std_msgs.msg import Bool

from motor_bridge.command_inputs import CommandInputs
from motor_bridge.core.base_drive import BaseDrive
from motor_bridge.core.controller_protocol import ControllerSetup
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, DriveSettings, Velocity
from motor_bridge.core.encoder_odometry import EncoderOdometry
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.core.ros_arduino_bridge import RosArduinoBridge
from motor_bridge.link.controller_session import ControllerSession, LinkReport, MotorLoop
from motor_bridge.link.serial_port import SerialPort
from motor_bridge.node_output import (
    EmergencyStop,
    OdometryPublisher,
    bridge_status,
    estop_file,
    is_stop_kept,
    keep_stop,
)
from motor_bridge.node_settings import NodeSettings
from shirube_ros.callback_guard import create_trigger_service
from shirube_ros.diagnostics import Status
from shirube_ros.input_watch import Need
from shirube_ros.managed_node import ManagedNode
from shirube_ros.node import run_node
from shirube_ros.quality_of_service import map_profile, pose_profile

AUTO_STOP_PERIODS = 3.0
"""Least auto-stop that is set in the controller, in periods of the update rate."""
_GRAPH_PERIOD = 0.25  # period of looking for publishers with stored messages of estop [s]


class MotorBridgeNode(ManagedNode):
    """Drives a differential drive robot over a serial motor controller.

    =====================  =================  ========================================================================
    subscribed             type               use
    =====================  =================  ========================================================================
    ``cmd_vel``            TwistStamped       velocity command; Twist with ``stamped:=false``; or ``mux_topics``
    ``joint_commands``     JointState         velocities of the wheels instead, with ``command_type:=joints``
    ``estop``              Bool               emergency stop: true stops at once until false is received, over restarts
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
            raise MotorBridgeError('left_wheel_joint and right_wheel_joint are equal; give them different names')
        DiffDriveKinematics(self.settings(DriveSettings))

    def configure(self) -> None:
        """Subscribe to velocity commands and the emergency stop."""
        self._settings, drive = self.settings(NodeSettings), self.settings(DriveSettings)
        self._is_simulated = bool(self.get_parameter('use_sim_time').value)
        self._output = OdometryPublisher(self, self._settings)
        self._session = self._make_session(drive)
        kinematics = DiffDriveKinematics(drive)
        self._commands = CommandInputs(self, self._settings, kinematics, self._now, self._set_target)
        self._commands.timeout = drive.cmd_vel_timeout
        self._load_estop()
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
        self._commands.timeout = drive.cmd_vel_timeout

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
        self._commands.subscribe(self._guard.guard)
        for topic in self._commands.topics:
            self._inputs.add(topic, Need.COMMAND, remedy='change stamped or command_type')
        # An emergency stop also holds for the time after the node is activated.
        self.subscribe(Bool, 'estop', self._take_estop, pose_profile(), Need.REQUEST, while_inactive=True)
        self._stored_estop: Subscription | None = None
        self.create_guarded_timer(_GRAPH_PERIOD, 'publishers of estop', self._watch_stored_estop)

    def _cycle(self) -> None:
        self._apply_estop()
        if self._loop is not None:
            self._loop.cycle()

    def _set_target(self, velocity: Velocity) -> None:
        if self._loop is not None:
            self._loop.set_target(velocity)

    def _now(self) -> float:
        """Return simulated time or a monotonic clock [s], so that setting the wall clock has no effect."""
        return float(self.get_clock().now().nanoseconds * 1e-9) if self._is_simulated else monotonic()

    def _log_link_state(self, message: str, is_connected: bool) -> None:
        if is_connected:
            self.get_logger().info(f'{self._settings.port}: {message}')
        else:
            self.get_logger().warning(message)

    def _load_estop(self) -> None:
        self._estop_file = estop_file(self._settings.state_dir, self.get_fully_qualified_name())
        is_on = self._settings.keep_estop and is_stop_kept(self._estop_file)
        self._estop = EmergencyStop(self._settings.estop_heartbeat, is_latched=is_on)
        self._apply_estop()
        if is_on:
            self.get_logger().warning(f'{self._estop.reason(self._now())} ({self._estop_file})')

    def _take_estop(self, message: Bool) -> None:
        before = self._estop.is_latched
        self._estop.take(self._now(), is_on=message.data)
        self._apply_estop()
        if self._settings.keep_estop and message.data != before:
            try:
                keep_stop(self._estop_file, is_on=message.data)
            except MotorBridgeError as fault:
                self.get_logger().warning(str(fault))

    def _apply_estop(self) -> None:
        is_on = bool(self._estop.reason(self._now()))
        if is_on != self._session.drive.is_stopped:
            with self._session.lock:
                self._session.drive.set_emergency_stop(is_on=is_on)
            if self._loop is not None:
                self._loop.wake()

    def _watch_stored_estop(self) -> None:
        """Receive the stored messages of transient local publishers of estop, if there are any.

        Such a subscription does not match volatile publishers. It only stops the robot: a stored release may be older
        than the stop.
        """
        infos = self.get_publishers_info_by_topic(self.resolve_topic_name('estop'))
        is_stored = any(i.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL for i in infos)
        if is_stored and self._stored_estop is None:
            take = self._guard.guard('estop', self._take_stored_estop)
            events = SubscriptionEventCallbacks(use_default_callbacks=False)
            self._stored_estop = self.create_subscription(Bool, 'estop', take, map_profile(), event_callbacks=events)
        elif not is_stored and self._stored_estop is not None:
            self.destroy_subscription(self._stored_estop)
            self._stored_estop = None

    def _take_stored_estop(self, message: Bool) -> None:
        if message.data:
            self._take_estop(message)

    def _reset_odometry(self) -> str:
        with self._session.lock:
            self._session.odometry.reset()
        return 'odometry reset to the origin'

    def status(self) -> Status:
        """Return the status of the serial link, the wheels and cmd_vel."""
        now, commands = self._now(), self._commands
        problems = [self._estop.reason(now), *map(commands.conflict, commands.topics)]
        publishers = sum(map(commands.publisher_count, commands.topics))
        return bridge_status(self._session, now, publishers, next(filter(None, problems), ''))

    def destroy_node(self) -> None:
        """Stop the motors and destroy the node."""
        self.halt()
        super().destroy_node()


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node('motor_bridge', MotorBridgeNode)


if __name__ == '__main__':
    sys.exit(main())
