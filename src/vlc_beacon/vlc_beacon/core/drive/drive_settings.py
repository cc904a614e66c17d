"""Settings of driving by lamp commands."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class DriveSettings:
    """Motion parameters used when `drive` is true."""

    cruise_speed: float = setting(
        0.3,
        'forward speed until a command changes it, and after resume',
        unit='m/s',
        minimum=0.0,
        maximum=10.0,
    )
    acceleration: float = setting(
        0.5, 'maximum forward acceleration and deceleration', unit='m/s^2', minimum=0.01, maximum=10.0
    )
    turn_rate_max: float = setting(1.0, 'maximum yaw rate', unit='rad/s', minimum=0.05, maximum=10.0)
    turn_acceleration: float = setting(
        2.0, 'maximum yaw acceleration', unit='rad/s^2', minimum=0.05, maximum=50.0
    )
    turn_tolerance: float = setting(
        math.radians(1.0),
        'a turn is complete when the remaining angle is below this',
        unit='rad',
        minimum=0.001,
        maximum=0.3,
    )
    line_distance: float = setting(
        0.5,
        'lookahead distance along the reference line',
        unit='m',
        minimum=0.05,
        maximum=10.0,
    )
    pose_timeout: float = setting(
        0.5,
        'maximum age of a pose; without a newer one the robot brakes',
        unit='s',
        minimum=0.02,
        maximum=10.0,
    )
