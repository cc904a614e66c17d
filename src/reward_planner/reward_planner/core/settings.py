"""Settings of planning, driving, mapping, stereo and voxels; the node declares each as a parameter."""

from dataclasses import astuple, dataclass, field

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.safety.footprint import Footprint
from shirube_core.settings import setting, tunable


@tunable()
@dataclass(frozen=True)
class PlannerSettings:
    """Planning mode, shape of the robot and costs of routes."""

    mode: str = setting(
        'optimal',
        "planning mode: the route of least cost, or the paper's reward rule (without costs)",
        choices=('optimal', 'reward'),
    )
    robot_radius: float = setting(
        0.2, 'radius of the circle around the robot; its centre keeps farther from obstacles', 'm', (0.0, 10.0)
    )
    footprint: tuple[float, ...] = setting(
        (),
        'corners of the robot in base_frame, as in collision_monitor: x, y of the first, x, y of the second ...; empty '
        'takes the circle of robot_radius, which the greatest circle around base_frame in the footprint replaces else',
        'm',
        (-10.0, 10.0),
    )
    inflation_radius: float = setting(
        0.55,
        'routes cost more up to this distance from obstacles; without effect below robot_radius + clearance_margin',
        'm',
        (0.0, 10.0),
    )
    cost_scaling_factor: float = setting(
        3.0,
        'decay k of the cost exp(-k (d - robot_radius - clearance_margin)) at a distance d from obstacles; 0 disables '
        'costs: the shortest route',
        '1/m',
        (0.0, 100.0),
    )
    cost_travel_multiplier: float = setting(
        2.0, 'a metre at the greatest cost counts as so many metres more', limits=(0.0, 100.0)
    )
    unknown: str = setting('free', 'whether routes may enter unknown cells', choices=('free', 'blocked'))


@tunable()
@dataclass(frozen=True)
class RewardTable:
    """Table 1 of the paper: rewards and penalties of one step, in the rows of the table."""

    advance: float = setting(100.0, 'row 1: a free step earns this/L - L, L cells from the goal', limits=(0.0, 1e6))
    collision: float = setting(-1000.0, 'row 2: the step hits an obstacle', limits=(-1e6, 0.0))
    outside: float = setting(-1000.0, 'row 3: the step leaves the map', limits=(-1e6, 0.0))
    visited: float = setting(-250.0, 'row 4: the step enters a visited cell', limits=(-1e6, 0.0))
    detour: float = setting(
        -100.0, 'row 5: neither this step nor the last one goes straight to the goal', limits=(-1e6, 0.0)
    )

    def reward_values(self) -> NDArray[np.float64]:
        """Return the rows as an array for numba kernels, shape (5,)."""
        return np.array(astuple(self), dtype=np.float64)


@tunable()
@dataclass(frozen=True)
class RewardSettings:
    """Penalties, virtual search and the reward table."""

    visits: str = setting(
        'once',
        'penalty of a visited cell: once, as in the paper, or counted for each visit',
        choices=('once', 'counted'),
    )
    virtual_steps_max: int = setting(
        5000, 'maximum number of steps of the virtual search; 0 disables it', limits=(0, 10_000_000)
    )
    table: RewardTable = field(default_factory=RewardTable)


def check_planner_settings(planner: PlannerSettings) -> None:
    """Raise a RewardPlannerError if the footprint is no polygon around the base frame's origin."""
    if planner.footprint:
        _ = Footprint(planner.footprint, planner.robot_radius).inscribed_radius


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
        'wait look_around back_up clear replan wait clear',
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


@dataclass(frozen=True)
class MappingSettings:
    """Pose lookup, jump detection and maximum size of the global map."""

    pose_wait: float = setting(0.5, 'time after which a frame without a pose is dropped', 's', (0.0, 10.0))
    pose_gap_max: float = setting(0.5, 'largest gap between two poses that is interpolated', 's', (0.01, 10.0))
    speed_max: float = setting(3.0, 'a pose has jumped if it implies a higher speed', 'm/s', (0.01, 50.0))
    turn_rate_max: float = setting(6.0, 'a pose has jumped if it implies a higher turn rate', 'rad/s', (0.01, 100.0))
    settle_time: float = setting(
        1.0, 'poses after a jump are accepted once they have been consistent for this time', 's', (0.0, 60.0)
    )
    cells_max: int = setting(
        16_000_000,
        'maximum number of cells of the map and of a costmap; larger maps are rejected',
        limits=(1_000_000, 32_000_000),  # longer routes do not fit into the keys of D* Lite
    )


@dataclass(frozen=True)
class DepthSettings:
    """OpenCV's stereo matchers, and the fusion of two pairs."""

    matcher: str = setting(
        'sgbm',
        'sgbm: semi-global matching in three directions; bm: block matching, three times as fast, with large gaps',
        choices=('sgbm', 'bm'),
    )
    disparities: int = setting(64, 'largest disparity, a multiple of 16; nearer points are lost', 'px', (16, 512))
    block: int = setting(3, 'side of a matched block, odd', 'px', (3, 31))
    uniqueness: int = setting(10, 'uniqueness ratio: margin of the best match over others', '%', (0, 99))
    speckle: int = setting(60, 'speckle filter: smaller islands of depth are dropped, 0 disables it', 'px', (0, 10_000))
    fusion: str = setting(
        'union',
        'agreement keeps depths that both pairs confirm, union also those of one pair; inconsistent ones are dropped',
        choices=('union', 'agreement'),
    )
    agreement: float = setting(1.0, 'largest difference of disparities at which two pairs agree', 'px', (0.1, 10.0))


def check_matcher_settings(settings: DepthSettings) -> None:
    """Raise a RewardPlannerError for settings that OpenCV's matchers reject."""
    if settings.disparities % 16 or settings.block % 2 == 0:
        raise RewardPlannerError(
            f'disparities is {settings.disparities} and block {settings.block}; give a multiple of 16 and an odd number'
        )


FREE_FRACTION = 0.5
"""A voxel is free below minus this fraction of log_odds_pass; higher values are decayed evidence."""


@tunable(
    'value_min',
    'hit_fraction_min',
    'log_odds_hit',
    'log_odds_pass',
    'log_odds_max',
    'log_odds_min',
    'log_odds_occupied',
    'half_life',
    'obstacle_memory',
)
@dataclass(frozen=True)
class VoxelSettings:
    """Size and extent of the voxels, and the rule of their values.

    See `VoxelMap` for the rules: ``count`` is eq. (3) of the paper, ``range_normalised`` removes its bias against far
    voxels, ``log_odds`` also clears the space in front of an obstacle.
    """

    rule: str = setting('log_odds', 'rule of the voxel values', choices=('count', 'range_normalised', 'log_odds'))
    resolution: float = setting(0.05, 'side of a voxel and of a map cell', 'm', (0.01, 1.0))
    height_min: float = setting(0.1, 'lowest height of obstacles', 'm', (-2.0, 5.0))
    height_max: float = setting(1.2, 'greatest height of obstacles', 'm', (-1.0, 6.0))
    range_min: float = setting(0.3, 'least distance of points; nearer ones are dropped', 'm', (0.0, 5.0))
    range_max: float = setting(
        5.0, 'greatest distance of obstacle points; rays of farther ones only clear space', 'm', (0.5, 50.0)
    )
    value_min: float = setting(
        0.05, 'least value of an obstacle with the rules count and range_normalised', limits=(0.001, 1.0)
    )
    hit_fraction_min: float = setting(
        0.05,
        'a voxel is hit if it has at least this fraction of the points of a surface across it (log_odds)',
        limits=(0.0, 1.0),
        former_name='hit_share_min',
    )
    log_odds_hit: float = setting(0.85, 'log-odds that a hit adds', limits=(0.01, 5.0))
    log_odds_pass: float = setting(0.4, 'log-odds that a ray through the voxel subtracts', limits=(0.01, 5.0))
    log_odds_max: float = setting(3.5, 'upper limit of the log-odds', limits=(0.5, 20.0))
    log_odds_min: float = setting(-2.0, 'lower limit of the log-odds', limits=(-20.0, -0.1))
    log_odds_occupied: float = setting(1.0, 'least value of an obstacle with the rule log_odds', limits=(0.01, 20.0))
    half_life: float = setting(
        300.0, 'half-life of the values of voxels that are not observed; cells of the map do not decay', 's', (1.0, 1e6)
    )
    obstacle_memory: float = setting(
        2.0,
        'time after which the part of an obstacle that is out of view is dropped, when rays cleared the rest of it; '
        'ten times as long where the floor was never seen free (log_odds)',
        's',
        (0.0, 1e6),
    )
    tiles_max: int = setting(
        2048, 'maximum number of tiles of 16 x 16 voxel columns; the nearest ones are kept', limits=(16, 1_000_000)
    )
