"""Subscriptions to velocity commands: twists or wheel speeds, on one topic or on several with priorities."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from inspect import Parameter, Signature
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import JointState

from motor_bridge.core.command_arbitration import CommandMux, CommandTopic, SenderMonitor, parse_mux_topics
from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, Velocity, check_velocity
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.node_settings import NodeSettings
from shirube_ros.managed_node import ManagedNode
from shirube_ros.quality_of_service import overridable, pose_profile


class _CallbackWithInfo:
    """Takes a message with its info; rclpy's EventsExecutor passes them as one argument, other executors as two."""

    __signature__ = Signature([Parameter(name, Parameter.POSITIONAL_ONLY) for name in ('message', 'info')])

    def __init__(self, take: Callable[[Any], None]) -> None:
        self._take = take

    def __call__(self, *received: Any) -> None:
        self._take(received[0] if len(received) == 1 else received)


class CommandInputs:
    """Converts commands to velocities; those that are refused are a MotorBridgeError, caught by the node's guard.

    Attributes:
        timeout: greatest age of a stamp [s].
        topics: topics of commands with their priorities.
    """

    def __init__(
        self,
        node: ManagedNode,
        settings: NodeSettings,
        kinematics: DiffDriveKinematics,
        now: Callable[[], float],
        set_target: Callable[[Velocity], None],
    ) -> None:
        """Prepare; ``set_target`` is called with each velocity to drive.

        Raises:
            MotorBridgeError: invalid ``mux_topics``.
        """
        self._node, self._settings, self._kinematics = node, settings, kinematics
        self._now, self._set_target = now, set_target
        self.timeout = 0.0
        self.topics = parse_mux_topics(settings.mux_topics) or [CommandTopic(settings.command_topic)]
        self._mux = CommandMux(self.topics)
        self._senders = {topic.name: SenderMonitor() for topic in self.topics}

    def subscribe(self, guard: Callable[[str, Callable[[Any], None]], Callable[[Any], None]]) -> None:
        """Subscribe to the topics with guarded callbacks."""
        twist = TwistStamped if self._settings.stamped else Twist
        kind = JointState if self._settings.command_type == 'joints' else twist
        for topic in self.topics:
            self._subscribe(kind, topic.name, guard(topic.name, partial(self._take, topic.name)))

    def _subscribe(self, kind: type, topic: str, take: Callable[[Any], None]) -> None:
        self._node.create_subscription(
            kind,
            topic,
            _CallbackWithInfo(take),
            pose_profile(),
            qos_overriding_options=overridable(),
        )

    def _take(self, topic: str, received: tuple[Any, dict[str, int | None]]) -> None:
        message, info = received
        self._check_stamp(topic, message)
        is_selected = self._mux.take(topic, self._now())
        try:
            velocity = self._velocity(topic, message)
            self._check_senders(topic, info.get('publication_sequence_number'), velocity)
        except MotorBridgeError:
            if is_selected:
                self._set_target(Velocity())  # brake at once, rather than after the timeout
            raise
        if is_selected:
            self._set_target(velocity)

    def _check_stamp(self, topic: str, message: Any) -> None:
        header = getattr(message, 'header', None)
        if header is None or not (header.stamp.sec or header.stamp.nanosec):  # 0 means now
            return
        stamp = float(header.stamp.sec + header.stamp.nanosec * 1e-9)
        age = float(self._node.get_clock().now().nanoseconds * 1e-9) - stamp
        if age > self.timeout:
            raise MotorBridgeError(f'{topic} is too old; synchronize the clocks or check the network')
        if age < -self.timeout:
            raise MotorBridgeError(
                f'{topic} has a stamp in the future; synchronize the clocks and set use_sim_time in both nodes'
            )

    def _velocity(self, topic: str, message: Any) -> Velocity:
        if not isinstance(message, JointState):
            twist = message.twist if isinstance(message, TwistStamped) else message
            return check_velocity(twist.linear.x, twist.angular.z, topic)
        names = self._settings.left_wheel_joint, self._settings.right_wheel_joint
        speeds = dict(zip(message.name, message.velocity, strict=False))
        if len(message.name) != len(message.velocity) or not all(name in speeds for name in names):
            raise MotorBridgeError(
                f'{topic} has no velocity of {names[0]} and {names[1]}; check its publisher'
            )
        return check_velocity(*self._kinematics.to_velocity(*(speeds[name] for name in names)), topic)

    def _check_senders(self, topic: str, number: int | None, velocity: Velocity) -> None:
        self._senders[topic].take(number, velocity, self._now())
        conflict = self._conflict(topic)
        if conflict:
            raise MotorBridgeError(conflict)

    def _conflict(self, topic: str) -> str:
        """Return which nodes send on a topic at the same time; empty if one does."""
        resolved = self._node.resolve_topic_name(topic)
        if self._node.count_publishers(resolved) < 2 or not self._senders[topic].is_mixed(self._now()):
            return ''
        infos = self._node.get_publishers_info_by_topic(resolved)
        names = sorted(f'{info.node_namespace.rstrip("/")}/{info.node_name}' for info in infos)
        return (
            f'{" and ".join(names)} send on {topic} at the same time, all are ignored; '
            'stop all but one, or use mux_topics'
        )

    def conflict(self) -> str:
        """Return which nodes send on one topic at the same time; empty if none do."""
        return next(filter(None, (self._conflict(topic.name) for topic in self.topics)), '')

    def publisher_count(self) -> int:
        """Return the number of publishers of all topics."""
        return sum(self._node.count_publishers(self._node.resolve_topic_name(t.name)) for t in self.topics)
