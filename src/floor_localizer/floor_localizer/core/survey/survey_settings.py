"""Settings of a floor survey."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class SurveySettings:
    """Accuracy of odometry, camera and floor, and how the survey is divided."""

    odometry_position_tolerance: float = setting(
        0.004,
        'position error of odometry between two images',
        unit='m',
        minimum=0.0001,
        maximum=0.1,
        former_name='odometry_radius',
    )
    odometry_yaw_tolerance: float = setting(
        0.03,
        'yaw error of odometry between two images',
        unit='rad',
        minimum=0.0001,
        maximum=0.5,
        former_name='odometry_turn',
    )
    odometry_error: float = setting(
        0.05, 'growth of these errors per metre driven, in m/m and rad/m', minimum=0.0, maximum=0.5
    )
    image_step: float = setting(
        0.35, 'motion between two used images as a fraction of the view width', minimum=0.0, maximum=0.9
    )
    submap_length: float = setting(
        4.0, 'length of a submap in view widths', minimum=2.0, maximum=20.0, former_name='piece_length'
    )
    scale_sigma: float = setting(
        0.01, 'relative variation of the camera height, standard deviation', minimum=0.0001, maximum=0.05
    )
    tilt_sigma: float = setting(
        0.01, 'tilt of the robot body, standard deviation', unit='rad', minimum=0.0001, maximum=0.05
    )
    dot_sigma: float = setting(
        0.00003,
        'standard deviation of a dot on the floor, in addition to image noise',
        unit='m',
        minimum=0.0,
        maximum=0.001,
    )
    merge_distance: float = setting(
        0.0006,
        'observations closer than this are merged into one dot',
        unit='m',
        minimum=0.0001,
        maximum=0.005,
        former_name='same_dot',
    )
    chance_alignments_max: float = setting(
        1e-6,
        'largest expected number of equally good matches by chance, for a match to be accepted',
        minimum=1e-12,
        maximum=0.01,
        former_name='chance',
    )
