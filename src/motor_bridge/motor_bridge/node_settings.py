"""The node's parameters besides those of the wheels, which are the core's own settings."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class NodeSettings:
    """The line to the controller, topics and frames."""

    port: str = setting('/dev/ttyUSB0', 'serial port of the motor controller')
    baud: int = setting(57600, 'rate of the line', unit='baud', minimum=1200, maximum=4_000_000)
    reply_timeout: float = setting(
        0.2,
        'the controller is silent when no reply came for so long; always wall-clock time',
        unit='s',
        minimum=0.005,
        maximum=1.0,
    )
    update_rate: float = setting(
        30.0,
        'how often speeds are sent, encoders read and odometry published',
        unit='Hz',
        minimum=5.0,
        maximum=200.0,
    )
    stamped: bool = setting(True, 'whether cmd_vel is TwistStamped; else it is Twist')
    publish_tf: bool = setting(
        True, 'whether odom_frame to base_frame is published on /tf, where tf2 is installed'
    )
    odom_frame: str = setting('odom', 'frame of odometry')
    base_frame: str = setting('base_link', 'frame of the robot, in the middle between its wheels')
    left_wheel_joint: str = setting('left_wheel_joint', 'name in joint_states')
    right_wheel_joint: str = setting('right_wheel_joint', 'name in joint_states')
    gain_proportional: int = setting(20, "of the firmware's speed control", minimum=0, maximum=1000)
    gain_derivative: int = setting(12, "of the firmware's speed control", minimum=0, maximum=1000)
    gain_integral: int = setting(0, "of the firmware's speed control", minimum=0, maximum=1000)
    gain_divisor: int = setting(
        50, 'by which the firmware divides what the gains make', minimum=1, maximum=1000
    )

    @property
    def gains(self) -> tuple[int, int, int, int]:
        """Proportional, derivative, integral and divisor."""
        return self.gain_proportional, self.gain_derivative, self.gain_integral, self.gain_divisor
