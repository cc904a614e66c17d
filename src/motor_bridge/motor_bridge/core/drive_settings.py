"""The wheels, the limits of the motion, and how sure odometry is."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class DriveSettings:
    """A base on two driven wheels and the controller of its motors."""

    wheel_radius: float = setting(0.033, 'radius of the wheels', unit='m', minimum=0.005, maximum=1.0)
    wheel_separation: float = setting(
        0.2, 'distance between the middles of the wheels', unit='m', minimum=0.02, maximum=5.0
    )
    ticks_per_revolution: int = setting(
        1440, 'counts of the encoder for one turn of a wheel', minimum=4, maximum=1_000_000
    )
    pid_frame: float = setting(
        0.033,
        'period of the speed control in the firmware, in which it counts speeds',
        unit='s',
        minimum=0.001,
        maximum=1.0,
    )
    auto_stop: float = setting(
        2.0,
        'the firmware stops the motors so long after the last command',
        unit='s',
        minimum=0.1,
        maximum=10.0,
    )
    cmd_vel_timeout: float = setting(
        0.5, 'the robot brakes when cmd_vel is silent for so long', unit='s', minimum=0.05, maximum=2.0
    )
    max_linear_velocity: float = setting(0.5, 'greatest speed', unit='m/s', minimum=0.01, maximum=10.0)
    max_angular_velocity: float = setting(1.5, 'greatest turn rate', unit='rad/s', minimum=0.05, maximum=20.0)
    max_linear_acceleration: float = setting(
        0.5, 'greatest change of the speed, up and down', unit='m/s^2', minimum=0.01, maximum=20.0
    )
    max_angular_acceleration: float = setting(
        3.0, 'greatest change of the turn rate', unit='rad/s^2', minimum=0.05, maximum=100.0
    )
    max_linear_jerk: float = setting(
        5.0,
        'greatest change of the acceleration; that of the turn rate is limited in the same proportion',
        unit='m/s^3',
        minimum=0.1,
        maximum=1000.0,
    )
    odometry_noise: float = setting(
        0.01,
        'standard deviation of the way of a wheel after one metre; it grows with the square root of the way',
        unit='m',
        minimum=0.0001,
        maximum=1.0,
    )
