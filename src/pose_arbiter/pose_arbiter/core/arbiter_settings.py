"""What can be set about the method."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class ArbiterSettings:
    """History, gate, errors of odometry, and what it takes to believe a source or to stop believing it."""

    history_seconds: float = setting(
        2.0, 'poses and odometry that come later than this are too old', unit='s', minimum=0.1, maximum=30.0
    )
    gate_probability: float = setting(
        0.99,
        'share of honest poses that pass the gate (chi-square, 3 degrees)',
        minimum=0.5,
        maximum=0.999999,
    )
    way_noise: float = setting(
        0.05, 'error of odometry along x and y after a metre', unit='m', minimum=1e-4, maximum=1.0
    )
    turn_noise: float = setting(
        0.04, 'error of its heading after a metre, and after a radian', unit='rad', minimum=1e-4, maximum=1.0
    )
    way_bias: float = setting(
        0.05,
        'share of the way, or radians a metre, by which odometry may lastingly be off',
        minimum=1e-3,
        maximum=1.0,
    )
    speed_max: float = setting(
        3.0, 'odometry that says faster has jumped', unit='m/s', minimum=0.1, maximum=50.0
    )
    turn_rate_max: float = setting(
        10.0, 'odometry that says faster has jumped', unit='rad/s', minimum=0.1, maximum=100.0
    )
    drift_speed: float = setting(
        0.5, 'how fast the robot may move while there is no odometry', unit='m/s', minimum=0.01, maximum=10.0
    )
    drift_turn_rate: float = setting(
        0.5, 'how fast it may turn then', unit='rad/s', minimum=0.01, maximum=10.0
    )
    slack_xy: float = setting(
        0.005, 'a difference between opinions that is none', unit='m', minimum=0.0, maximum=0.5
    )
    slack_yaw: float = setting(
        0.005, 'a difference between headings that is none', unit='rad', minimum=0.0, maximum=0.5
    )
    lasting_share: float = setting(
        0.35, "share of a source's variance that more poses do not average away", minimum=0.0, maximum=0.95
    )
    lasting_way: float = setting(
        3.0,
        'way after which what lasts has become another; a radian counts as 1 m',
        unit='m',
        minimum=0.1,
        maximum=10000.0,
    )
    reset_count: int = setting(
        5,
        'so many poses that agree with each other move a pose that nobody stands by',
        minimum=2,
        maximum=100,
    )
    witness_seconds: float = setting(
        1.0, "over this time a source's motion is compared with odometry", unit='s', minimum=0.1, maximum=10.0
    )
    start_seconds: float = setting(
        1.0, 'at the start so long a second source is waited for', unit='s', minimum=0.0, maximum=60.0
    )
    established_count: int = setting(
        30,
        'after so many used poses the word of a source counts more than that of a new one',
        minimum=1,
        maximum=10000,
    )
    lost_sigma_xy: float = setting(
        0.5, 'less sure than this the pose is lost', unit='m', minimum=0.01, maximum=100.0
    )
    lost_sigma_yaw: float = setting(
        0.35, 'less sure than this the pose is lost', unit='rad', minimum=0.01, maximum=3.2
    )
