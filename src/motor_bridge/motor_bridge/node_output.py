"""What the node publishes: odometry, its transform and the diagnostics of the controller."""

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from motor_bridge.core.encoder_monitor import CountStatus
from motor_bridge.core.encoder_odometry import OdometryState
from motor_bridge.link.controller_session import ControllerSession
from motor_bridge.node_settings import NodeSettings
from shirube_ros.diagnostics import Level, Status
from shirube_ros.frames import TransformPublisher
from shirube_ros.pose_conversion import odometry_message
from shirube_ros.quality_of_service import pose_profile


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
        """Create the publishers."""
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
