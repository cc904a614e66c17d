"""Settings of driving by the lamps' commands."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class DriveSettings:
    """How the robot drives while `drive` is on."""

    cruise_speed: float = setting(
        0.3,
        'speed ahead until a lamp says otherwise, and after resume',
        unit='m/s',
        minimum=0.0,
        maximum=10.0,
    )
    acceleration: float = setting(
        0.5, 'largest change of the speed, up and down', unit='m/s^2', minimum=0.01, maximum=10.0
    )
    turn_rate_max: float = setting(1.0, 'largest turn rate', unit='rad/s', minimum=0.05, maximum=10.0)
    turn_acceleration: float = setting(
        2.0, 'largest change of the turn rate', unit='rad/s^2', minimum=0.05, maximum=50.0
    )
    turn_tolerance: float = setting(
        math.radians(1.0),
        'a turn is done when so little of it is left',
        unit='rad',
        minimum=0.001,
        maximum=0.3,
    )
    line_distance: float = setting(
        0.5,
        'distance over which the robot comes back to its line',
        unit='m',
        minimum=0.05,
        maximum=10.0,
    )
    pose_timeout: float = setting(
        0.5, 'the robot brakes when its last pose is older', unit='s', minimum=0.02, maximum=10.0
    )
