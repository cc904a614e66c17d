"""Settings of the command authorization."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class AuthorizationSettings:
    """Conditions for accepting a command."""

    speed_limit: float = setting(0.5, 'maximum speed of any command', unit='m/s', minimum=0.0, maximum=10.0)
    zone_radius: float = setting(
        0.3,
        'maximum horizontal distance to its beacon at which a command is accepted',
        unit='m',
        minimum=0.05,
        maximum=50.0,
    )
    position_age_max: float = setting(
        1.0,
        'maximum age of the position used to accept commands',
        unit='s',
        minimum=0.01,
        maximum=60.0,
    )
    bad_macs_max: int = setting(
        5, 'number of wrong authentication codes that triggers the lockout', minimum=1, maximum=1000
    )
    lockout_time: float = setting(
        60.0,
        'time window of wrong authentication codes, and duration of the lockout',
        unit='s',
        minimum=1.0,
        maximum=86400.0,
    )
