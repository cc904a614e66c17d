"""Parameters of the node; those of wheels and limits are settings of the core."""

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class NodeSettings:
    """Serial port, topics, frames and gains."""

    port: str = setting('/dev/ttyUSB0', 'serial port of the motor controller')
    baud: int = setting(57600, 'baud rate of the serial port', 'baud', (1200, 4_000_000))
    reply_timeout: float = setting(
        0.2, 'timeout of a reply of the controller; always wall-clock time', 's', (0.005, 1.0)
    )
    short_auto_stop: float = setting(
        0.25,
        'auto-stop that is set in a controller that accepts it (firmware/motor_controller); longer on lines with '
        'latency, and at least three periods of update_rate',
        's',
        (0.2, 2.0),
    )
    update_rate: float = setting(
        30.0, 'rate of sending speeds, reading encoders and publishing odometry', 'Hz', (5.0, 200.0)
    )
    stamped: bool = setting(True, 'whether cmd_vel is TwistStamped; otherwise it is Twist')
    command_type: str = setting(
        'twist',
        'twist: cmd_vel; joints: velocities of both wheels on joint_commands (JointState), as of ros2_control',
        choices=('twist', 'joints'),
    )
    mux_topics: str = setting(
        '',
        'topics of commands by priority, such as joy_vel, cmd_vel: the first one that has not timed out after '
        'cmd_vel_timeout drives; empty: cmd_vel or joint_commands alone',
    )
    estop_heartbeat: float = setting(
        0.0, 'without estop messages for so long the robot stops; 0: never', 's', (0.0, 10.0)
    )
    keep_estop: bool = setting(True, 'whether an emergency stop outlives a restart, until false is received')
    state_dir: str = setting('', 'folder of the file for that; empty: $ROS_HOME/shirube or ~/.ros/shirube')
    publish_tf: bool = setting(True, 'whether odom_frame to base_frame is published on /tf, if tf2_msgs is installed')
    odom_frame: str = setting('odom', 'frame of odometry')
    base_frame: str = setting('base_link', 'frame of the robot, midway between its wheels')
    left_wheel_joint: str = setting('left_wheel_joint', 'name of the left wheel in joint_states')
    right_wheel_joint: str = setting('right_wheel_joint', 'name of the right wheel in joint_states')
    gain_proportional: int = setting(20, "proportional gain of the firmware's speed control", limits=(0, 1000))
    gain_derivative: int = setting(12, "derivative gain of the firmware's speed control", limits=(0, 1000))
    gain_integral: int = setting(0, "integral gain of the firmware's speed control", limits=(0, 1000))
    gain_divisor: int = setting(50, "divisor of the firmware's speed control output", limits=(1, 1000))

    @property
    def gains(self) -> tuple[int, int, int, int]:
        """Proportional, derivative and integral gain, and divisor."""
        return self.gain_proportional, self.gain_derivative, self.gain_integral, self.gain_divisor
