"""Settings of what is believed."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class TrustSettings:
    """When a command is obeyed."""

    speed_limit: float = setting(
        0.5, 'speed that no command can exceed', unit='m/s', minimum=0.0, maximum=10.0
    )
    zone_radius: float = setting(
        0.3,
        'horizontal distance from its beacon within which a command is obeyed',
        unit='m',
        minimum=0.05,
        maximum=50.0,
    )
    position_age_max: float = setting(
        1.0,
        'a position that is older does not prove where the robot is',
        unit='s',
        minimum=0.01,
        maximum=60.0,
    )
    bad_macs_max: int = setting(
        5, 'commands with a wrong code of authentication until all are refused', minimum=1, maximum=1000
    )
    lockout_time: float = setting(
        60.0,
        'how long wrong codes are remembered, and how long commands are refused after too many of them',
        unit='s',
        minimum=1.0,
        maximum=86400.0,
    )
