"""The localizer's settings: one set for all floors, because everything that depends on the floor is computed."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class LocalizerSettings:
    """Settings of the matching."""

    match_rate_min: float = setting(
        0.25,
        'minimum fraction of the dots in view that match the map (paper: reference match rate)',
        minimum=0.0,
        maximum=1.0,
    )
    chance_alignments_max: float = setting(
        1e-3,
        'maximum expected number of equally good chance alignments of an accepted pose',
        minimum=1e-12,
        maximum=0.1,
    )
    scale_tolerance: float = setting(
        0.05,
        'maximum relative error of the height of the camera above the floor',
        minimum=0.001,
        maximum=0.15,
    )
    tilt_tolerance: float = setting(
        0.035, 'maximum tilt (roll, pitch) of the robot', unit='rad', minimum=0.001, maximum=0.1
    )
    map_sigma: float = setting(
        0.00005, "standard deviation of the map's dots along each axis", unit='m', minimum=0.0, maximum=0.01
    )
    cells_max: int = setting(
        400000,
        'maximum number of index cells opened for one view before the pair search',
        minimum=0,
        maximum=100000000,
    )
    pairs_max: int = setting(
        24,
        'maximum number of pairs of one view that are matched to the whole map if no constellation matched',
        minimum=0,
        maximum=10000,
    )


@dataclass(frozen=True)
class TrackerSettings:
    """Settings of the pose prediction and of the search between images."""

    odometry_error: float = setting(
        0.05,
        'error of the odometry as a fraction of the distance driven, and in rad/m',
        minimum=0.0,
        maximum=1.0,
    )
    still_radius: float = setting(
        0.003,
        'search radius around the predicted pose with odometry, without motion',
        unit='m',
        minimum=0.0001,
        maximum=1.0,
    )
    still_turn: float = setting(
        0.02,
        'yaw tolerance of the predicted pose with odometry, without motion',
        unit='rad',
        minimum=0.0001,
        maximum=3.2,
    )
    acceleration_max: float = setting(
        3.0,
        'maximum acceleration of the robot, used without odometry',
        unit='m/s^2',
        minimum=0.01,
        maximum=50.0,
    )
    turn_acceleration_max: float = setting(
        10.0,
        'maximum angular acceleration, used without odometry',
        unit='rad/s^2',
        minimum=0.01,
        maximum=500.0,
    )
    prior_radius_max: float = setting(
        0.3,
        'maximum radius of a prior; a less certain prediction is ignored',
        unit='m',
        minimum=0.01,
        maximum=10.0,
    )
    chance_alignments_alone_max: float = setting(
        1e-6,
        'a first pose with more expected chance alignments must be confirmed by the next view',
        minimum=1e-12,
        maximum=0.1,
    )
    thorough_interval: float = setting(
        1.0,
        'period of thorough searches of the whole map while the robot is lost',
        unit='s',
        minimum=0.0,
        maximum=60.0,
    )
    thorough_effort: float = setting(
        0.3, 'fraction of cells_max and pairs_max for a thorough search', minimum=0.0, maximum=1.0
    )
    usual_effort: float = setting(
        0.04, 'the same for every other image that does not match within the prior', minimum=0.0, maximum=1.0
    )
    joined_views: int = setting(
        4, 'maximum number of views merged by odometry if one view has too few dots', minimum=1, maximum=20
    )
