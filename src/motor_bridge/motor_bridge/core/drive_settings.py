"""Settings of wheels, velocity limits and odometry noise."""

from dataclasses import dataclass

from shirube_core.settings import setting, tunable


@tunable(
    'cmd_vel_timeout',
    'max_linear_velocity',
    'max_angular_velocity',
    'max_linear_acceleration',
    'max_angular_acceleration',
    'max_linear_jerk',
)
@dataclass(frozen=True)
class DriveSettings:
    """A differential drive base and its motor controller."""

    wheel_radius: float = setting(0.033, 'wheel radius', 'm', (0.005, 1.0))
    wheel_separation: float = setting(0.2, 'distance between the centres of the wheels', 'm', (0.02, 5.0))
    ticks_per_revolution: int = setting(1440, 'encoder counts per revolution of a wheel', limits=(4, 1_000_000))
    pid_frame: float = setting(
        0.033, "control period (frame) of the firmware's speed control, the unit of its speeds", 's', (0.001, 1.0)
    )
    auto_stop: float = setting(
        2.0,
        'longest time after the last command at which the firmware stops the motors, that of ROSArduinoBridge',
        's',
        (0.1, 10.0),
    )
    cmd_vel_timeout: float = setting(0.5, 'timeout of cmd_vel, after which the robot brakes', 's', (0.05, 2.0))
    max_linear_velocity: float = setting(0.5, 'maximum linear speed', 'm/s', (0.01, 10.0))
    max_angular_velocity: float = setting(1.5, 'maximum turn rate', 'rad/s', (0.05, 20.0))
    max_linear_acceleration: float = setting(0.5, 'maximum linear acceleration and deceleration', 'm/s^2', (0.01, 20.0))
    max_angular_acceleration: float = setting(3.0, 'maximum angular acceleration', 'rad/s^2', (0.05, 100.0))
    max_linear_jerk: float = setting(
        5.0, 'maximum linear jerk; angular jerk is limited in the same proportion', 'm/s^3', (0.1, 1000.0)
    )
    odometry_noise: float = setting(
        0.01,
        'standard deviation of a wheel distance after one metre; it grows with the square root of the distance',
        'm',
        (0.0001, 1.0),
    )
