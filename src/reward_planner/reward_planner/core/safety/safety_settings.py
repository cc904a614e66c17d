"""Settings of the collision monitor and of each of its range sensors."""

from dataclasses import dataclass

from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.settings import setting

OPTICAL_RPY = (-1.5707963267948966, 0.0, -1.5707963267948966)
"""A level optical frame that looks along x of the base [rad]."""


@dataclass(frozen=True)
class CollisionMonitorSettings:
    """Footprint, braking, zones and assumed speeds of obstacles."""

    footprint: tuple[float, ...] = setting(
        (),
        'corners of the footprint in base_frame: x, y of the first, x, y of the second ...; empty takes a circle of '
        'robot_radius',
        'm',
        (-10.0, 10.0),
    )
    robot_radius: float = setting(0.2, 'radius of a circular footprint', 'm', (0.01, 10.0))
    deceleration: float = setting(
        0.5, 'linear acceleration and deceleration of the base, as its driver limits it', 'm/s^2', (0.05, 20.0)
    )
    angular_deceleration: float = setting(3.0, 'angular acceleration and deceleration', 'rad/s^2', (0.05, 100.0))
    latency: float = setting(0.1, 'time from a published velocity until the base follows it', 's', (0.0, 2.0))
    rate: float = setting(20.0, 'rate of the published velocity; new ranges are published at once', limits=(5.0, 200.0))
    command_timeout: float = setting(0.5, 'the robot stops when the latest cmd_vel_in is older', 's', (0.05, 10.0))
    stop_margin: float = setting(0.05, 'stop zone: width around the footprint', 'm', (0.0, 2.0))
    slow_margin: float = setting(0.05, 'slow-down zone: width around the path of the stop zone', 'm', (0.0, 5.0))
    slow_time: float = setting(1.0, 'slow-down zone: length, as time at the commanded velocity', 's', (0.0, 10.0))
    slow_fraction: float = setting(
        0.5, 'greatest fraction of the command with points in the slow-down zone', limits=(0.05, 1.0)
    )
    obstacle_speed: float = setting(1.6, 'greatest speed of people; ISO 13855 uses 1.6', 'm/s', (0.0, 10.0))
    yield_time: float = setting(
        4.0, 'the robot gives way to people whom its commanded drive would meet within this time', 's', (0.0, 10.0)
    )
    memory: float = setting(
        600.0,
        'an obstacle that left the field of view is kept for this long, but not once the robot has driven 2 m since; '
        'people who came and stood, 10 s at most',
        's',
        (0.0, 1e6),
    )
    exclusion_zones: tuple[float, ...] = setting(
        (),
        'boxes in base_frame whose points are ignored (parts of the robot): lowest x, y, z, greatest x, y, z of each',
        'm',
        (-20.0, 20.0),
    )


@dataclass(frozen=True)
class SourceSettings:
    """One range sensor; the parameters are ``<name>.type`` and so on."""

    type: str = setting('points', 'kind of messages', choices=('points', 'depth', 'scan'))
    topic: str = setting(
        '', 'topic; empty takes points, depth/image or scan; the CameraInfo of depth is camera_info beside the image'
    )
    frame: str = setting('', 'frame of the messages; empty takes that of the first message; others are rejected')
    timeout: float = setting(0.5, 'the robot stops when the latest message is older', 's', (0.02, 10.0))
    xyz: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.3),
        'position of the sensor frame in base_frame, whose plane z = 0 is the floor',
        'm',
        (-10.0, 10.0),
    )
    rpy: tuple[float, ...] = setting(
        (),
        'fixed-axis roll, pitch, yaw of the sensor frame in base_frame; empty: level, looking along x (points and '
        'depth: an optical frame)',
        'rad',
        (-7.0, 7.0),
    )
    height_min: float = setting(0.08, 'lowest height of obstacles', 'm', (-2.0, 5.0))
    height_max: float = setting(1.2, 'greatest height of obstacles', 'm', (-1.0, 6.0))
    range_min: float = setting(0.05, 'nearer points are noise', 'm', (0.0, 5.0))
    range_max: float = setting(4.0, 'farther points are not used', 'm', (0.5, 20.0))
    range_noise: float = setting(
        0.01, 'standard deviation of a range of 1 m; it grows with the square', 'm', (None, 0.5)
    )
    points_min: int = setting(
        3, 'fewer points within 0.15 m are noise; images have 20000 points at most', limits=(1, 1000)
    )


def check_limits(name: str, source: SourceSettings) -> None:
    """Raise a RewardPlannerError if limits of a source contradict each other."""
    if source.height_min >= source.height_max:
        raise RewardPlannerError(f'{name}.height_min is not below {name}.height_max; exchange them')
    if source.range_min >= source.range_max:
        raise RewardPlannerError(f'{name}.range_min is not below {name}.range_max; exchange them')
    if len(source.rpy) not in (0, 3):
        raise RewardPlannerError(f'{name}.rpy has {len(source.rpy)} numbers; give roll, pitch and yaw, or none')


def sensor_rpy(source: SourceSettings) -> tuple[float, float, float]:
    """Return the fixed-axis roll, pitch, yaw of the sensor frame in the base frame [rad]."""
    if source.rpy:
        roll, pitch, yaw = source.rpy
        return roll, pitch, yaw
    return (0.0, 0.0, 0.0) if source.type == 'scan' else OPTICAL_RPY
