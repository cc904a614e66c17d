"""Publishes velocities, and sees to it that no velocity stands when nobody decides any more."""

from __future__ import annotations

from time import monotonic

from geometry_msgs.msg import TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import Header

from shirube_ros.quality_of_service import pose_profile

_STALL = 0.5  # time that stands so long is paused [s]
_LOOK_PERIOD = 0.1  # between looks at the time [s]
_LAST_WORD = Duration(seconds=0.2)  # within it, listeners acknowledge the last velocity


class VelocityOutput:
    """Velocities of the robot on one topic; while simulated time is paused, the robot stands."""

    def __init__(self, node: Node, topic: str, base_frame: str) -> None:
        """Advertise.

        Args:
            node: the node that publishes.
            topic: of the velocities.
            base_frame: name of the robot's frame.
        """
        self._clock, self._base_frame = node.get_clock(), base_frame
        self._publisher = node.create_publisher(TwistStamped, topic, pose_profile())
        self._is_moving = False
        self._time, self._moved_on = self._clock.now(), monotonic()
        # A steady clock: what decides on velocities sleeps while simulated time stands still.
        node.create_timer(_LOOK_PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def send(self, forward: float, turn_rate: float) -> None:
        """Publish a speed [m/s] and a turn rate [rad/s]."""
        stamp = self._clock.now().to_msg()
        message = TwistStamped(header=Header(stamp=stamp, frame_id=self._base_frame))
        message.twist.linear.x, message.twist.angular.z = forward, turn_rate
        self._is_moving = forward != 0.0 or turn_rate != 0.0
        self._publisher.publish(message)

    def stop(self) -> None:
        """Publish a velocity of zero if another one stands, and wait a little until it is received: the node ends."""
        if self._is_moving:
            self.send(0.0, 0.0)
            self._publisher.wait_for_all_acked(_LAST_WORD)

    def _look(self) -> None:
        now = self._clock.now()
        if now != self._time:
            self._time, self._moved_on = now, monotonic()
        elif self._is_moving and monotonic() - self._moved_on > _STALL:
            self.send(0.0, 0.0)
