"""Publishes velocities, and a zero velocity when the node ends or simulated time is paused."""

from time import monotonic

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import Header

from shirube_ros.quality_of_service import pose_profile

_CLOCK_TIMEOUT = 0.5  # simulated time unchanged for this long is paused [s]
_CHECK_PERIOD = 0.1  # period of the clock check [s]
_ACK_TIMEOUT = Duration(seconds=0.2)  # timeout for subscribers to acknowledge the last velocity


class VelocityPublisher:
    """Publishes velocities on one topic; stops the robot while simulated time is paused."""

    def __init__(self, node: Node, topic: str, base_frame: str, *, stamped: bool = True) -> None:
        """Create the publisher of a topic, for the robot with a base frame; without stamps it publishes Twist."""
        self._clock, self._base_frame, self._stamped = node.get_clock(), base_frame, stamped
        kind = TwistStamped if stamped else Twist
        self._publisher = node.create_publisher(kind, topic, pose_profile())
        self._is_moving = False
        self._time, self._clock_changed_at = self._clock.now(), monotonic()
        # A steady clock: the node's other timers do not fire while simulated time is paused.
        node.create_timer(_CHECK_PERIOD, self._check_clock, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def send(self, forward: float, yaw_rate: float) -> None:
        """Publish a forward speed [m/s] and a yaw rate [rad/s]."""
        stamp = self._clock.now().to_msg()
        message = TwistStamped(header=Header(stamp=stamp, frame_id=self._base_frame))
        message.twist.linear.x, message.twist.angular.z = forward, yaw_rate
        self._is_moving = forward != 0.0 or yaw_rate != 0.0
        self._publisher.publish(message if self._stamped else message.twist)

    def stop(self) -> None:
        """Publish a zero velocity if the robot is moving, and wait shortly for acknowledgement; call at shutdown."""
        if self._is_moving:
            self.send(0.0, 0.0)
            self._publisher.wait_for_all_acked(_ACK_TIMEOUT)

    def _check_clock(self) -> None:
        now = self._clock.now()
        if now != self._time:
            self._time, self._clock_changed_at = now, monotonic()
        elif self._is_moving and monotonic() - self._clock_changed_at > _CLOCK_TIMEOUT:
            self.send(0.0, 0.0)
