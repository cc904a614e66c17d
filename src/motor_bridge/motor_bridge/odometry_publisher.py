"""Publishes odometry, joint states and, if tf2_msgs is installed, the transform."""

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from motor_bridge.core.encoder_odometry import OdometryState
from motor_bridge.node_settings import NodeSettings
from shirube_ros.pose_conversion import odometry_message
from shirube_ros.quality_of_service import pose_profile
from shirube_ros.transform_publisher import TransformPublisher

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
