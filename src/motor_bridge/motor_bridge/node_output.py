"""What the node publishes (odometry, its transform, diagnostics), and its emergency stop, kept in a file."""

import math
import os
from pathlib import Path

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from motor_bridge.core.encoder_monitor import CountStatus
from motor_bridge.core.encoder_odometry import OdometryState
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.link.controller_session import ControllerSession
from motor_bridge.node_settings import NodeSettings
from shirube_core.files import atomic_write
from shirube_ros.diagnostics import Level, Status
from shirube_ros.frames import TransformPublisher
from shirube_ros.message_conversion import odometry_message
from shirube_ros.quality_of_service import pose_profile


class EmergencyStop:
    """Stops from a true until a false, and without messages.

    Attributes:
        is_latched: whether the last message was true.
    """

    def __init__(self, heartbeat: float, *, is_latched: bool) -> None:
        """Start, perhaps still stopped from before a restart; a ``heartbeat`` [s] of 0 is none."""
        self._heartbeat, self.is_latched = heartbeat, is_latched
        self._last_time: float | None = None

    def take(self, now: float, *, is_on: bool) -> None:
        """Take a message, received at a time [s]."""
        self.is_latched, self._last_time = is_on, now

    def reason(self, now: float) -> str:
        """Return why the robot must not drive at a time [s]; empty if it may."""
        if self.is_latched and self._last_time is None:
            return 'stopped by estop before the restart; publish false on estop to release it'
        if self.is_latched:
            return 'stopped by estop'
        age = math.inf if self._last_time is None else now - self._last_time
        if self._heartbeat > 0.0 and not 0.0 <= age <= self._heartbeat:
            return f'stopped, no message on estop for {self._heartbeat:g} s (estop_heartbeat); check its publisher'
        return ''


def estop_file(state_dir: str, node_name: str) -> Path:
    """Return the path of a node's file, by default below ``ROS_HOME``."""
    folder = state_dir or f'{os.environ.get("ROS_HOME") or "~/.ros"}/shirube'
    return Path(os.path.expanduser(folder)) / f'{node_name.strip("/").replace("/", ".")}.estop'  # noqa: PTH111 no error


def is_stop_kept(path: Path) -> bool:
    """Return whether the emergency stop was active; a file that cannot be checked counts as active."""
    try:
        path.lstat()
    except OSError as fault:
        return not isinstance(fault, (FileNotFoundError, NotADirectoryError))
    return True


def keep_stop(path: Path, *, is_on: bool) -> None:
    """Create or delete the file; it is on the disk afterwards, so that a power failure does not lose it.

    Raises:
        MotorBridgeError: a read-only or full disk.
    """
    try:
        if is_on:
            with atomic_write(path) as file:
                file.write(b'The emergency stop is active; publish false on estop to release it.\n')
                file.flush()
                os.fsync(file.fileno())
        else:
            path.unlink(missing_ok=True)
    except OSError as fault:
        what = 'active, but not kept over' if is_on else 'released, but only until'
        raise MotorBridgeError(
            f'estop is {what} a restart: {path}: {fault.strerror}; set state_dir to a writable folder'
        ) from fault


def bridge_status(session: ControllerSession, now: float, publishers: int, problem: str) -> Status:
    """Return the diagnostic status of the serial link, the wheels and the commands.

    ``now`` is 0 before simulated time starts; ``publishers`` is the number of those of commands; ``problem`` why they
    are ignored, or empty.
    """
    report = session.report
    with session.lock:
        velocity = session.drive.velocity
        is_timed_out = session.drive.is_timed_out(now)
        status_counts = dict(session.odometry.status_counts)
    level, message = Level.OK, 'driving'
    if now <= 0.0:
        level, message = Level.WARN, 'waiting for /clock; publish it, or set use_sim_time to false'
    elif not report.is_connected:
        level, message = Level.ERROR, report.state
    elif problem:
        level, message = Level.WARN, problem
    elif is_timed_out:
        message = 'stopped, cmd_vel timed out' if publishers else 'stopped, no publisher of cmd_vel'
    values = {
        'forward [m/s]': f'{velocity.forward:.3f}',
        'turn rate [rad/s]': f'{velocity.turn_rate:.3f}',
        'connections': str(report.connections),
    }
    values |= {kind: str(number) for kind, number in dict(report.faults).items()}
    values |= {f'counts {status.value}': str(status_counts.get(status, 0)) for status in CountStatus}
    return Status(level, message, values)


_TWIST = np.ix_([0, 5], [0, 5])  # indices of vx and the yaw rate in a twist


class OdometryPublisher:
    """Publishes odometry messages."""

    def __init__(self, node: Node, settings: NodeSettings) -> None:
        self._clock, self._settings = node.get_clock(), settings
        self._odometry = node.create_publisher(Odometry, 'odom', pose_profile())
        self._joints = node.create_publisher(JointState, 'joint_states', pose_profile())
        self._transforms = TransformPublisher(node) if settings.publish_tf else None

    def publish(self, state: OdometryState) -> None:
        """Publish odometry with the current stamp."""
        stamp = self._clock.now().to_msg()
        header = Header(stamp=stamp, frame_id=self._settings.odom_frame)
        message = odometry_message(state.T_odom_base, state.covariance, header, self._settings.base_frame)
        message.twist.twist.linear.x = state.velocity.forward
        message.twist.twist.angular.z = state.velocity.turn_rate
        covariance = np.zeros((6, 6))
        covariance[_TWIST] = state.velocity_covariance
        message.twist.covariance = covariance.ravel()
        self._odometry.publish(message)
        names = [self._settings.left_wheel_joint, self._settings.right_wheel_joint]
        self._joints.publish(
            JointState(header=Header(stamp=stamp), name=names, position=list(state.angles), velocity=list(state.speeds))
        )
        if self._transforms is not None:
            self._transforms.publish(stamp, header.frame_id, message.child_frame_id, message.pose.pose)
