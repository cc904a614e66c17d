"""Subscriptions to velocity commands: twists or wheel speeds, on one topic or on several with priorities."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from inspect import Parameter, Signature
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState

from motor_bridge.core.diff_drive_kinematics import DiffDriveKinematics, Velocity, check_velocity
from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.node_settings import NodeSettings
from shirube_ros.quality_of_service import overridable, pose_profile

MIXED_TIME = 1.0
"""Commands are mixed until none was for this time; a sender that is silent for so long sends no more [s]."""
_NUMBER_STEP_MAX = 20  # so many messages of a publisher may be lost in a row
_SPEED_STEP_MAX = 0.2  # between two messages of one publisher [m/s, rad/s]


@dataclass(frozen=True)
class _Command:
    number: int | None
    velocity: Velocity
    time: float

    def gap(self, after: _Command) -> float:
        """Return how far another command is from this one; infinite if it cannot be the next one of its sender."""
        if self.number is not None and after.number is not None:
            gap: float = after.number - self.number
            return gap if 0 < gap <= _NUMBER_STEP_MAX else math.inf
        a, b = self.velocity, after.velocity
        gap = max(abs(a.forward - b.forward), abs(a.turn_rate - b.turn_rate))
        return gap if gap <= _SPEED_STEP_MAX else math.inf


class SenderMonitor:
    """Notices when the commands of several senders are interleaved, though messages do not name their sender.

    A publisher numbers its messages, so each continues a row of numbers or begins one. Commands are mixed if one
    continues a row that is not the latest: A, B, A. One publisher after another is not mixed. Where the middleware does
    not pass on the numbers, a row is one of similar velocities.
    """

    def __init__(self) -> None:
        self._rows: list[_Command] = []  # the last command of each sender, the latest one last
        self._mixed_time = -math.inf

    def take(self, number: int | None, velocity: Velocity, now: float) -> None:
        """Take a command that was received at a time [s]; its number may not be known."""
        command = _Command(number, velocity, now)
        rows = [row for row in self._rows if 0.0 <= now - row.time <= MIXED_TIME]
        candidates = [row for row in reversed(rows) if row.gap(command) < math.inf]
        if candidates:
            continued = min(candidates, key=lambda row: row.gap(command))
            if continued is not rows[-1]:
                self._mixed_time = now
            rows.remove(continued)
        self._rows = [*rows, command]

    def is_mixed(self, now: float) -> bool:
        """Return whether commands were mixed shortly before a time [s]."""
        return 0.0 <= now - self._mixed_time <= MIXED_TIME


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
        timeout: greatest age of a stamp, and time after which a topic has no priority any more [s].
        topics: names of the topics, the highest priority first.
    """

    def __init__(
        self,
        node: Node,
        settings: NodeSettings,
        kinematics: DiffDriveKinematics,
        now: Callable[[], float],
        set_target: Callable[[Velocity], None],
    ) -> None:
        """Prepare; ``set_target`` is called with each velocity to drive."""
        self._node, self._settings, self._kinematics = node, settings, kinematics
        self._now, self._set_target = now, set_target
        self._has_joints, self.timeout = settings.command_type == 'joints', 0.0
        self.topics = settings.mux_topics.replace(',', ' ').split()
        self.topics = self.topics or ['joint_commands' if self._has_joints else 'cmd_vel']
        self._times = dict.fromkeys(self.topics, -math.inf)
        self._senders = {topic: SenderMonitor() for topic in self.topics}

    def subscribe(self, guard: Callable[[str, Callable[[Any], None]], Callable[[Any], None]]) -> None:
        """Subscribe to the topics with guarded callbacks."""
        kind = JointState if self._has_joints else TwistStamped if self._settings.stamped else Twist
        for topic in self.topics:
            take = _CallbackWithInfo(guard(topic, partial(self._take, topic)))
            self._node.create_subscription(kind, topic, take, pose_profile(), qos_overriding_options=overridable())

    def _take(self, topic: str, received: tuple[Any, dict[str, int | None]]) -> None:
        message, info = received
        self._check_stamp(topic, message)
        now = self._times[topic] = self._now()
        alive = (each for each in self.topics if 0.0 <= now - self._times[each] <= self.timeout)
        is_selected = next(alive) == topic
        try:
            velocity = self._velocity(topic, message)
            self._senders[topic].take(info.get('publication_sequence_number'), velocity, now)
            if conflict := self.conflict(topic):
                raise MotorBridgeError(conflict)
        except MotorBridgeError:
            if is_selected:
                self._set_target(Velocity())  # brake at once, rather than after the timeout
            raise
        if is_selected:
            self._set_target(velocity)

    def _check_stamp(self, topic: str, message: Any) -> None:
        if isinstance(message, Twist) or not (message.header.stamp.sec or message.header.stamp.nanosec):
            return  # 0 means now
        stamp = float(message.header.stamp.sec + message.header.stamp.nanosec * 1e-9)
        age = float(self._node.get_clock().now().nanoseconds * 1e-9) - stamp
        if age > self.timeout:
            raise MotorBridgeError(f'{topic} is too old; synchronize the clocks or check the network')
        if age < -self.timeout:
            raise MotorBridgeError(
                f'{topic} has a stamp in the future; synchronize the clocks and set use_sim_time in both nodes'
            )

    def _velocity(self, topic: str, message: Any) -> Velocity:
        if not self._has_joints:
            twist = message.twist if self._settings.stamped else message
            return check_velocity(twist.linear.x, twist.angular.z, topic)
        names = self._settings.left_wheel_joint, self._settings.right_wheel_joint
        speeds = dict(zip(message.name, message.velocity, strict=False))
        if len(message.name) != len(message.velocity) or not speeds.keys() >= {*names}:
            raise MotorBridgeError(f'{topic} has no velocity of {names[0]} and {names[1]}; check its publisher')
        return check_velocity(*self._kinematics.to_velocity(*(speeds[name] for name in names)), topic)

    def conflict(self, topic: str) -> str:
        """Return which nodes send on a topic at the same time; empty if at most one does."""
        if not self._senders[topic].is_mixed(self._now()) or self.publisher_count(topic) < 2:
            return ''
        infos = self._node.get_publishers_info_by_topic(self._node.resolve_topic_name(topic))
        names = sorted(f'{info.node_namespace.rstrip("/")}/{info.node_name}' for info in infos)
        return f'{" and ".join(names)} send on {topic} at the same time, all are ignored; stop one, or use mux_topics'

    def publisher_count(self, topic: str) -> int:
        """Return the number of publishers of a topic."""
        return int(self._node.count_publishers(self._node.resolve_topic_name(topic)))
