"""Settings of the target search and of its acceptance."""

from __future__ import annotations

import math
from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class SearchSettings:
    """Search region of the pose, and acceptance thresholds of a target."""

    distance_max: float = setting(
        0.8,
        'maximum distance of the robot from the taught pose',
        unit='m',
        minimum=0.05,
        maximum=10.0,
        former_name='reach',
    )
    yaw_max: float = setting(
        math.radians(20.0),
        'maximum yaw of the robot relative to the taught pose',
        unit='rad',
        minimum=0.02,
        maximum=1.2,
        former_name='turn',
    )
    window: float = setting(
        12.0,
        'search window around the predicted pixel of a primitive, plus a fraction of its distance from the first one',
        unit='px',
        minimum=2.0,
        maximum=100.0,
    )
    found_fraction_min: float = setting(
        0.5,
        'minimum fraction of the primitives of a target that must be found',
        minimum=0.1,
        maximum=1.0,
        former_name='seen_min',
    )
    detection_probability: float = setting(
        0.8,
        'probability that a visible primitive is detected',
        minimum=0.1,
        maximum=0.99,
        former_name='found_probability',
    )
    log_likelihood_ratio_min: float = setting(
        4.0,
        'minimum log-likelihood ratio against chance for accepting a pose hypothesis',
        minimum=0.0,
        maximum=100.0,
        former_name='evidence_min',
    )
    margin: float = setting(
        4.0,
        'minimum difference of the log-likelihood ratio to the runner-up; otherwise the result is ambiguous',
        minimum=0.0,
        maximum=100.0,
    )
