"""How far odometry is trusted between lamps."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class OdometrySettings:
    """Errors of the odometry, and how long it bridges gaps between lamps.

    The lasting errors are learned while lamps are in view. The random ones are those of good wheels far apart; wheels
    that slip by s after a metre, b apart, turn a robot by s sqrt(2) / b. Stated too small, they make each pose after a
    gap surer than it is.
    """

    scale_error: float = setting(
        0.02, 'lasting error of the way and of turns, as a share', minimum=0.0, maximum=0.5
    )
    turn_error: float = setting(
        0.0035, 'lasting turn for each metre driven', unit='rad/m', minimum=0.0, maximum=0.5
    )
    slip: float = setting(
        0.002,
        'random error of the way after one metre, it grows with the root of the way',
        unit='m',
        minimum=0.0,
        maximum=1.0,
    )
    turn_slip: float = setting(
        0.005,
        'random error of the heading after one metre or one radian',
        unit='rad',
        minimum=0.0,
        maximum=1.0,
    )
    lasting_way: float = setting(
        20.0, 'way after which the lasting errors may have changed', unit='m', minimum=0.1, maximum=10000.0
    )
    position_sigma_max: float = setting(
        0.3, 'a pose that is less certain than this is given up', unit='m', minimum=0.01, maximum=10.0
    )
    gap_way: float = setting(
        3.0,
        'a pose that was carried on so far without a lamp is not told until one is seen; a radian counts as 0.3 m',
        unit='m',
        minimum=0.0,
        maximum=1000.0,
    )
