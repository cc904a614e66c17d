"""Simulated tilt readings of an inertial unit: constant bias plus noise."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TiltErrors:
    """Errors of roll and pitch.

    Attributes:
        bias: standard deviation of the constant error of each axis, drawn once a run [rad].
        noise: standard deviation of a reading [rad].
    """

    bias: float = math.radians(0.05)
    noise: float = math.radians(0.03)


@dataclass(frozen=True)
class TiltReading:
    """A reading of the inertial unit.

    Attributes:
        time: [s].
        roll: fixed-axis roll of the body [rad].
        pitch: fixed-axis pitch of the body [rad].
    """

    time: float
    roll: float
    pitch: float


def simulate_tilt(
    tilt_at: Callable[[float], tuple[float, float]],
    times: Sequence[float],
    errors: TiltErrors,
    rng: np.random.Generator,
) -> list[TiltReading]:
    """Return readings of the tilt.

    Args:
        tilt_at: gives the true roll and pitch at a time [s].
        times: when the unit is read [s].
        errors: its errors.
        rng: source of bias and noise.
    """
    bias = errors.bias * rng.standard_normal(2)
    true = np.array([tilt_at(time) for time in times]).reshape(-1, 2)
    read = true + bias + errors.noise * rng.standard_normal(true.shape)
    return [
        TiltReading(time, float(roll), float(pitch)) for time, (roll, pitch) in zip(times, read, strict=True)
    ]
