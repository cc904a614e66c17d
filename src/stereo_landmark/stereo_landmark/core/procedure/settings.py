"""How targets are looked for, and when they are believed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class SearchSettings:
    """Where the robot may be, and what a target must show."""

    reach: float = setting(
        0.8, 'how far the robot may be from the taught pose', unit='m', minimum=0.05, maximum=10.0
    )
    turn: float = setting(
        math.radians(20.0),
        'how far it may have turned from the taught pose',
        unit='rad',
        minimum=0.02,
        maximum=1.2,
    )
    window: float = setting(
        12.0,
        'how far from where it is expected a primitive is looked for, besides a share for the way to it',
        unit='px',
        minimum=2.0,
        maximum=100.0,
    )
    seen_min: float = setting(
        0.5, 'part of the primitives of a target that must be found', minimum=0.1, maximum=1.0
    )
    found_probability: float = setting(
        0.8, 'how likely a primitive is found that should be in view', minimum=0.1, maximum=0.99
    )
    evidence_min: float = setting(
        4.0, 'log likelihood above chance that a place needs to be believed', minimum=0.0, maximum=100.0
    )
    margin: float = setting(
        4.0,
        'log likelihood by which it must be better than the next, else it is ambiguous',
        minimum=0.0,
        maximum=100.0,
    )
