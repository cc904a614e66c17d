"""Publishes odometry, joint states and, if tf2 is installed, the transform."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from motor_bridge.core.encoder_odometry import OdometryState
from motor_bridge.node_settings import NodeSettings
from shirube_ros.pose_conversion import odometry_message
from shirube_ros.quality_of_service import pose_profile

_TWIST = np.ix_([0, 5], [0, 5])  # indices of vx and the yaw rate in a twist


class OdometryPublisher:
    """Publishes odometry messages."""

    def __init__(self, node: Node, settings: NodeSettings) -> None:
        """Create the publishers."""
        self._clock, self._settings = node.get_clock(), settings
        self._odometry = node.create_publisher(Odometry, 'odom', pose_profile())
        self._joints = node.create_publisher(JointState, 'joint_states', pose_profile())
        self._broadcaster = _transform_broadcaster(node) if settings.publish_tf else None

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
            JointState(
                header=Header(stamp=stamp),
                name=names,
                position=list(state.angles),
                velocity=list(state.speeds),
            )
        )
        if self._broadcaster is not None:
            self._broadcaster.sendTransform(_transform(message))


def _transform(message: Odometry) -> TransformStamped:
    place = message.pose.pose.position
    return TransformStamped(
        header=message.header,
        child_frame_id=message.child_frame_id,
        transform=Transform(
            translation=Vector3(x=place.x, y=place.y, z=place.z), rotation=message.pose.pose.orientation
        ),
    )


def _transform_broadcaster(node: Node) -> Any:
    """Return tf2's broadcaster, None if tf2 is not installed."""
    try:
        return importlib.import_module('tf2_ros').TransformBroadcaster(node)
    except ImportError:
        node.get_logger().info('tf2_ros is not installed; odom -> base_link is not published on /tf')
        return None
