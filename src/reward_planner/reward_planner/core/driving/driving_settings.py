"""How the robot drives along its route."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class DrivingSettings:
    """Limits of the motors, distances to obstacles and goal, and when the robot stops because it does not know."""

    max_linear_velocity: float = setting(0.5, 'greatest speed', unit='m/s', minimum=0.01, maximum=10.0)
    max_angular_velocity: float = setting(1.5, 'greatest turn rate', unit='rad/s', minimum=0.05, maximum=20.0)
    max_linear_acceleration: float = setting(
        0.5, 'greatest change of the speed, up and down', unit='m/s^2', minimum=0.01, maximum=20.0
    )
    max_angular_acceleration: float = setting(
        3.0, 'greatest change of the turn rate', unit='rad/s^2', minimum=0.05, maximum=100.0
    )
    max_linear_jerk: float = setting(
        5.0, 'greatest change of the acceleration', unit='m/s^3', minimum=0.1, maximum=1000.0
    )
    clearance_margin: float = setting(
        0.1, 'routes keep so much more than robot_radius from obstacles', unit='m', minimum=0.0, maximum=2.0
    )
    slow_distance: float = setting(
        0.25,
        'the robot is slower where less room than this is between its rim and an obstacle',
        unit='m',
        minimum=0.01,
        maximum=5.0,
    )
    lookahead: float = setting(
        0.8, 'the robot heads for a point of the route so far ahead', unit='m', minimum=0.05, maximum=10.0
    )
    goal_tolerance: float = setting(
        0.1, 'the goal is reached so near to it', unit='m', minimum=0.01, maximum=5.0
    )
    goal_yaw_tolerance: float = setting(
        0.1, 'and with a heading that differs by no more', unit='rad', minimum=0.01, maximum=3.2
    )
    pose_timeout: float = setting(
        0.5, 'the robot stops when its newest pose is older', unit='s', minimum=0.05, maximum=10.0
    )
    map_timeout: float = setting(
        1.0,
        'the robot stops when the newest frame in the map is older',
        unit='s',
        minimum=0.05,
        maximum=60.0,
    )
    replan_gain: float = setting(
        0.1,
        'a free route is left for one that is shorter by this share',
        minimum=0.0,
        maximum=0.9,
    )
    replan_period: float = setting(
        1.0, 'a free route is compared with a new one this often', unit='s', minimum=0.05, maximum=60.0
    )
