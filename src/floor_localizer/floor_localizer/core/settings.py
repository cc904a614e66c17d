"""The localizer's settings: one set for every floor, because what depends on the floor is computed from its
map.
"""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class LocalizerSettings:
    """How dots are matched and when a match is taken."""

    match_rate_min: float = setting(
        0.25,
        'lowest share of the dots in view that must be found on the map (paper: reference match rate)',
        minimum=0.0,
        maximum=1.0,
    )
    chance_alignments_max: float = setting(
        1e-3,
        'a pose is taken when fewer poses as good are expected by chance on the whole map',
        minimum=1e-12,
        maximum=0.1,
    )
    scale_tolerance: float = setting(
        0.05, 'share by which the camera may hang higher or lower than mounted', minimum=0.001, maximum=0.15
    )
    tilt_tolerance: float = setting(
        0.035, 'tilt of the robot on its wheels', unit='rad', minimum=0.001, maximum=0.1
    )
    map_sigma: float = setting(
        0.00005,
        "accuracy of the map's dots, standard deviation along each axis",
        unit='m',
        minimum=0.0,
        maximum=0.01,
    )
    cells_max: int = setting(
        400000,
        'cells of the index that are opened for one view before pairs are tried',
        minimum=0,
        maximum=100000000,
    )
    pairs_max: int = setting(
        24,
        'pairs of one view that are laid on the whole map when no constellation matched',
        minimum=0,
        maximum=10000,
    )


@dataclass(frozen=True)
class TrackerSettings:
    """How far the robot may be from where it is expected."""

    odometry_error: float = setting(
        0.05,
        'error of the odometry as a share of the distance driven, and in rad/m',
        minimum=0.0,
        maximum=1.0,
    )
    still_radius: float = setting(
        0.003,
        'search radius around the expected pose with odometry at hand',
        unit='m',
        minimum=0.0001,
        maximum=1.0,
    )
    still_turn: float = setting(
        0.02, 'search range of the heading with odometry at hand', unit='rad', minimum=0.0001, maximum=3.2
    )
    acceleration_max: float = setting(
        3.0,
        'acceleration that the robot does not exceed, used without odometry',
        unit='m/s^2',
        minimum=0.01,
        maximum=50.0,
    )
    turn_acceleration_max: float = setting(
        10.0, 'angular acceleration that it does not exceed', unit='rad/s^2', minimum=0.01, maximum=500.0
    )
    prior_radius_max: float = setting(
        0.3, 'an expectation that is less certain than this is dropped', unit='m', minimum=0.01, maximum=10.0
    )
    chance_alignments_alone_max: float = setting(
        1e-6,
        'a first pose with more expected chance alignments waits until the next view confirms it',
        minimum=1e-12,
        maximum=0.1,
    )
    thorough_interval: float = setting(
        1.0,
        'time between thorough searches of the whole map while the robot is lost',
        unit='s',
        minimum=0.0,
        maximum=60.0,
    )
    thorough_effort: float = setting(
        0.3, 'share of cells_max and pairs_max that a thorough search may take', minimum=0.0, maximum=1.0
    )
    usual_effort: float = setting(
        0.04,
        'the same for every other image without a match near where the robot is expected',
        minimum=0.0,
        maximum=1.0,
    )
    joined_views: int = setting(
        4, 'so many views are joined by odometry when one alone has too few dots', minimum=1, maximum=20
    )
