"""Publishes map to odom on /tf, if tf2_ros is installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from pose_arbiter.stamp_conversion import time_message
from shirube_core.geometry import SE2
from shirube_ros.pose_conversion import pose_message


class TransformOutput:
    """Broadcasts one transform; does nothing if tf2_ros is not installed."""

    def __init__(self, node: Node, parent: str, child: str) -> None:
        """Create the broadcaster.

        Args:
            node: node that broadcasts.
            parent: map frame.
            child: odometry frame.
        """
        self._parent, self._child = parent, child
        self._broadcaster: Any = None
        try:
            self._broadcaster = import_module('tf2_ros').TransformBroadcaster(node)
        except ImportError:
            node.get_logger().info('tf2_ros is not installed; map to odom is not published')

    def send(self, T_map_odom: SE2, stamp: int) -> None:
        """Broadcast the pose of the child in the parent, valid until a stamp [ns]."""
        if self._broadcaster is None:
            return
        pose, message = pose_message(T_map_odom), TransformStamped()
        message.header.stamp, message.header.frame_id = time_message(stamp), self._parent
        message.child_frame_id = self._child
        message.transform.translation.x, message.transform.translation.y = pose.position.x, pose.position.y
        message.transform.rotation = pose.orientation
        self._broadcaster.sendTransform(message)
