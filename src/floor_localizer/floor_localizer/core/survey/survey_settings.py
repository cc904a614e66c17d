"""How a floor is surveyed."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class SurveySettings:
    """What the odometry, the camera and the floor are like."""

    odometry_radius: float = setting(
        0.004, 'error of the odometry from one image to the next', unit='m', minimum=0.0001, maximum=0.1
    )
    odometry_turn: float = setting(0.03, 'the same for the heading', unit='rad', minimum=0.0001, maximum=0.5)
    odometry_error: float = setting(
        0.05, 'what it grows by, as a share of the way, and in rad/m', minimum=0.0, maximum=0.5
    )
    image_step: float = setting(
        0.35, 'an image is used when the view has moved by this share of its width', minimum=0.0, maximum=0.9
    )
    piece_length: float = setting(
        4.0, 'images are put together to pieces of so many views', minimum=2.0, maximum=20.0
    )
    scale_sigma: float = setting(
        0.01, 'share by which the camera hangs higher or lower at times', minimum=0.0001, maximum=0.05
    )
    tilt_sigma: float = setting(
        0.01, 'tilt of the robot on its wheels', unit='rad', minimum=0.0001, maximum=0.05
    )
    dot_sigma: float = setting(
        0.00003, 'accuracy of a dot on the floor besides noise', unit='m', minimum=0.0, maximum=0.001
    )
    same_dot: float = setting(
        0.0006,
        'sightings that are nearer to each other are the same dot',
        unit='m',
        minimum=0.0001,
        maximum=0.005,
    )
    chance: float = setting(
        1e-6,
        'a link between places is taken when fewer as good are expected by chance',
        minimum=1e-12,
        maximum=0.01,
    )
