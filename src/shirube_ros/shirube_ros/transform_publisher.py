"""Publishes transforms on /tf or /tf_static, where the package tf2_msgs is installed."""

from importlib import import_module
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, Transform, TransformStamped, Vector3
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Header

_TF = QoSProfile(depth=100)
_STATIC = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class TransformPublisher:
    """Publishes transforms as tf2 does; only the messages of tf2 are needed, not its library."""

    def __init__(self, node: Node, *, is_static: bool = False) -> None:
        """Create the publisher; without tf2_msgs nothing is published, and for /tf the console says so."""
        self._is_static = is_static
        self._latched: dict[str, TransformStamped] = {}
        self._publisher: Any = None
        topic = '/tf_static' if is_static else '/tf'
        try:
            self._kind = import_module('tf2_msgs.msg').TFMessage
        except ImportError:
            if not is_static:
                node.get_logger().info('tf2_msgs is not installed; nothing is published on /tf')
            return
        self._publisher = node.create_publisher(self._kind, topic, _STATIC if is_static else _TF)

    def publish(self, stamp: Time, parent: str, child: str, pose: Pose) -> None:
        """Publish the pose of a child frame in its parent; static ones are kept for nodes that start later."""
        if self._publisher is None:
            return
        place = pose.position
        message = TransformStamped(
            header=Header(stamp=stamp, frame_id=parent),
            child_frame_id=child,
            transform=Transform(translation=Vector3(x=place.x, y=place.y, z=place.z), rotation=pose.orientation),
        )
        if self._is_static:
            self._latched[child] = message
        transforms = list(self._latched.values()) if self._is_static else [message]
        self._publisher.publish(self._kind(transforms=transforms))
