"""Settings of the filter, of outlier rejection and of each source of poses."""

import math
from dataclasses import dataclass

from shirube_core.settings import setting, tunable


@tunable(fixed=('history_seconds', 'speed_max', 'turn_rate_max'))
@dataclass(frozen=True)
class ArbiterSettings:
    """History length, gate, odometry noise, source bias, and the rules that accept or reject a source."""

    history_seconds: float = setting(
        2.0, 'messages that arrive later than this are rejected as too old', 's', (0.1, 30.0)
    )
    gate_probability: float = setting(
        0.99, 'fraction of correct poses that pass the gate (chi-square, 3 degrees of freedom)', limits=(0.5, 0.999999)
    )
    odometry_noise_xy: float = setting(
        0.05, 'standard deviation of odometry along x and y after 1 m', 'm', (1e-4, 1.0), former_name='way_noise'
    )
    odometry_noise_yaw: float = setting(
        0.04,
        'standard deviation of odometry yaw after 1 m, and after 1 rad',
        'rad',
        (1e-4, 1.0),
        former_name='turn_noise',
    )
    odometry_bias: float = setting(
        0.05,
        'systematic odometry error as a fraction of the distance, or rad per m',
        limits=(1e-3, 1.0),
        former_name='way_bias',
    )
    speed_max: float = setting(3.0, 'faster odometry is treated as a jump', 'm/s', (0.1, 50.0))
    turn_rate_max: float = setting(10.0, 'faster odometry is treated as a jump', 'rad/s', (0.1, 100.0))
    drift_speed: float = setting(0.5, 'assumed robot speed while there is no odometry', 'm/s', (0.01, 10.0))
    drift_turn_rate: float = setting(0.5, 'assumed yaw rate while there is no odometry', 'rad/s', (0.01, 10.0))
    gate_margin_xy: float = setting(
        0.005, 'position difference that the gate ignores', 'm', (0.0, 0.5), former_name='slack_xy'
    )
    gate_margin_yaw: float = setting(
        0.005, 'yaw difference that the gate ignores', 'rad', (0.0, 0.5), former_name='slack_yaw'
    )
    bias_fraction: float = setting(
        0.35,
        "fraction of a source's variance that is bias, not white noise",
        limits=(0.0, 0.95),
        former_name='lasting_share',
    )
    bias_correlation_length: float = setting(
        3.0,
        'distance over which a bias decorrelates (1 rad counts as 1 m)',
        'm',
        (0.1, 10000.0),
        former_name='lasting_way',
    )
    reset_count: int = setting(5, 'consistent rejected poses that reset an estimate without support', limits=(2, 100))
    consistency_window: float = setting(
        1.0,
        "time over which a source's motion is compared with odometry",
        's',
        (0.1, 10.0),
        former_name='witness_seconds',
    )
    start_seconds: float = setting(1.0, 'how long to wait for a second source at start', 's', (0.0, 60.0))
    established_count: int = setting(
        30, 'accepted poses after which a source gets 3 votes instead of 2', limits=(1, 10000)
    )
    lost_sigma_xy: float = setting(0.5, 'position standard deviation above which the pose is lost', 'm', (0.01, 100.0))
    lost_sigma_yaw: float = setting(0.35, 'yaw standard deviation above which the pose is lost', 'rad', (0.01, 3.2))


@tunable('sigma_xy', 'sigma_yaw', 'timeout', 'priority', 'offset')
@dataclass(frozen=True)
class SourceSettings:
    """Settings of one localizer; its parameters are called ``<name>.topic`` and so on."""

    topic: str = setting(
        '', 'topic of its poses; empty: <name>/pose_with_covariance, or <name>/pose without covariance'
    )
    with_covariance: bool = setting(
        True, 'true: the topic is PoseWithCovarianceStamped; false: PoseStamped with the sigmas below'
    )
    sigma_xy: float = setting(0.01, 'standard deviation along x and y of poses without covariance', 'm', (1e-6, 10.0))
    sigma_yaw: float = setting(
        0.01, 'standard deviation of the yaw of poses without covariance', 'rad', (1e-6, math.pi)
    )
    timeout: float = setting(1.0, 'a source without a message for this long is ignored', 's', (0.05, 60.0))
    priority: int = setting(0, 'at start, decides between two sources that disagree', limits=(-100, 100))
    frame: str = setting('', 'required frame_id of its poses; empty: map_frame')
    offset: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.0),
        'pose (x, y, yaw) of base_frame in the frame that the source localizes; zeros if that is base_frame',
        'm, m, rad',
        (-100.0, 100.0),
    )
