"""Settings of the drive controller."""

from dataclasses import dataclass

from shirube_core.settings import setting, tunable


@tunable(fixed=('look_around',))
@dataclass(frozen=True)
class DrivingSettings:
    """Velocity limits, distances to obstacles and goal, timeouts and replanning."""

    max_linear_velocity: float = setting(0.5, 'maximum linear speed', 'm/s', (0.01, 10.0))
    max_angular_velocity: float = setting(1.5, 'maximum turn rate', 'rad/s', (0.05, 20.0))
    max_linear_acceleration: float = setting(0.5, 'maximum linear acceleration and deceleration', 'm/s^2', (0.01, 20.0))
    max_angular_acceleration: float = setting(3.0, 'maximum angular acceleration', 'rad/s^2', (0.05, 100.0))
    max_linear_jerk: float = setting(5.0, 'maximum linear jerk', 'm/s^3', (0.1, 1000.0))
    clearance_margin: float = setting(
        0.1, 'clearance that routes keep from obstacles in addition to robot_radius', 'm', (0.0, 2.0)
    )
    slow_distance: float = setting(
        0.25, 'below this distance from its edge to an obstacle the robot slows down', 'm', (0.01, 5.0)
    )
    lookahead: float = setting(0.8, 'lookahead distance along the route', 'm', (0.05, 10.0))
    goal_tolerance: float = setting(0.1, 'position tolerance of the goal', 'm', (0.01, 5.0))
    goal_yaw_tolerance: float = setting(0.1, 'heading tolerance of the goal', 'rad', (0.01, 3.2))
    pose_timeout: float = setting(0.5, 'the robot stops when its latest pose is older', 's', (0.05, 10.0))
    map_timeout: float = setting(1.0, 'the robot stops when the latest frame in the map is older', 's', (0.05, 60.0))
    replan_gain: float = setting(
        0.1, 'a free route is replaced by one that is shorter by this fraction', limits=(0.0, 0.9)
    )
    replan_period: float = setting(1.0, 'period of comparing a free route with a new one', 's', (0.05, 60.0))
    look_around: bool = setting(
        False,
        "turn once in place where the surroundings are unknown, to map them (the paper's step 1); not for a camera "
        'that sees all around or turns itself',
    )
    recovery: str = setting(
        'look_around wait back_up clear replan wait clear',
        'recovery behaviors in their order, of look_around, wait, back_up, clear and replan, for a robot without a '
        'route; empty for none',
    )
    recovery_wait: float = setting(5.0, 'time of the recovery behavior wait', 's', (0.0, 600.0))
    recovery_distance: float = setting(0.3, 'distance of the recovery behavior back_up', 'm', (0.0, 5.0))
    recovery_radius: float = setting(
        5.0, 'the recovery behavior clear clears the map within this radius', 'm', (0.0, 50.0)
    )
    prediction_time: float = setting(2.5, 'time for which moving obstacles are predicted', 's', (0.0, 10.0))
    moving_obstacle_wait: float = setting(
        5.0, 'time of waiting for a moving obstacle before going around it', 's', (0.0, 600.0)
    )
