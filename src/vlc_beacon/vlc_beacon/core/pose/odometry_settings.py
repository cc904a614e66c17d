"""Noise of the odometry between lamps."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class OdometrySettings:
    """Errors of the odometry, and limits of dead reckoning between lamps.

    The biases are estimated while lamps are in view. The defaults of the random errors are those of good wheels with a
    large wheel separation; wheels that slip by s per metre, separated by b, rotate the robot by s sqrt(2) / b. If set
    too small, the covariance after a gap is too small.
    """

    scale_error: float = setting(
        0.02, 'bias of the driven distance and of yaw, as a fraction', minimum=0.0, maximum=0.5
    )
    turn_error: float = setting(
        0.0035, 'bias of yaw per metre driven', unit='rad/m', minimum=0.0, maximum=0.5
    )
    slip: float = setting(
        0.002,
        'random error of the distance after one metre; it grows with the square root of the distance',
        unit='m',
        minimum=0.0,
        maximum=1.0,
    )
    turn_slip: float = setting(
        0.005,
        'random error of yaw after one metre or one radian',
        unit='rad',
        minimum=0.0,
        maximum=1.0,
    )
    bias_correlation_length: float = setting(
        20.0,
        'correlation length of the odometry biases',
        unit='m',
        minimum=0.1,
        maximum=10000.0,
        former_name='lasting_way',
    )
    position_sigma_max: float = setting(
        0.3,
        'maximum position standard deviation; above it the pose is reset',
        unit='m',
        minimum=0.01,
        maximum=10.0,
    )
    gap_distance_max: float = setting(
        3.0,
        'maximum dead reckoning distance without a lamp for which poses are published; a radian counts as 0.3 m',
        unit='m',
        minimum=0.0,
        maximum=1000.0,
        former_name='gap_way',
    )
