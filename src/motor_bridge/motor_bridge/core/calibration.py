"""Calibration of wheel radius and separation from measured straights and turns."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from motor_bridge.core.motor_bridge_error import MotorBridgeError

_TICKS_MIN = 100  # least length of a run [ticks]
_RADIUS = 0.005, 1.0  # plausible wheel radii [m]
_SEPARATION = 0.02, 5.0  # plausible wheel separations [m]


@dataclass(frozen=True)
class MeasuredRun:
    """A straight run or a turn in place: encoder counts and the measured motion.

    Attributes:
        left: counts of the left wheel [ticks].
        right: counts of the right wheel [ticks].
        measured: measured distance forward [m] or turn counterclockwise [rad].
    """

    left: float
    right: float
    measured: float


@dataclass(frozen=True)
class WheelCalibration:
    """Calibrated wheels.

    Attributes:
        radius: wheel radius [m].
        separation: wheel separation [m].
        radius_spread: greatest deviation of a single straight from the radius [m].
        separation_spread: greatest deviation of a single turn from the separation [m].
        wheel_asymmetry: counts of the left wheel over those of the right one on straights, minus 1.
    """

    radius: float
    separation: float
    radius_spread: float
    separation_spread: float
    wheel_asymmetry: float


def calibrate_wheels(
    straights: Sequence[MeasuredRun], turns: Sequence[MeasuredRun], ticks_per_revolution: int
) -> WheelCalibration:
    """Fit radius and separation to measured distances and turns by least squares.

    A straight of s metres and n ticks has s = 2π·r·n / N, a turn of a radians has a·b = 2π·r·(n_r - n_l) / N.

    Raises:
        MotorBridgeError: no runs, contradictory runs, or implausible wheels.
    """
    if not straights or not turns:
        raise MotorBridgeError('give at least one straight and one turn')
    for run in straights:
        _check_run(run, 0.5 * (run.left + run.right), 'straight')
    for run in turns:
        _check_run(run, 0.5 * (run.right - run.left), 'turn')
    angles = [math.pi * (run.left + run.right) / ticks_per_revolution for run in straights]
    radius = _fit_slope(angles, [run.measured for run in straights])
    _check_range('wheel_radius', radius, _RADIUS)
    per_tick = math.tau * radius / ticks_per_revolution
    distances = [per_tick * (run.right - run.left) for run in turns]
    separation = _fit_slope([run.measured for run in turns], distances)
    _check_range('wheel_separation', separation, _SEPARATION)
    return WheelCalibration(
        radius,
        separation,
        max(abs(run.measured / angle - radius) for run, angle in zip(straights, angles, strict=True)),
        max(abs(distance / run.measured - separation) for run, distance in zip(turns, distances, strict=True)),
        sum(run.left for run in straights) / sum(run.right for run in straights) - 1.0,
    )


def _fit_slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Return the least-squares slope through the origin."""
    return sum(a * b for a, b in zip(x, y, strict=True)) / sum(a * a for a in x)


def _check_run(run: MeasuredRun, ticks: float, name: str) -> None:
    values = (run.left, run.right, run.measured)
    if not all(map(math.isfinite, values)) or abs(ticks) < _TICKS_MIN or run.measured == 0.0:
        raise MotorBridgeError(f'a {name} of {ticks:.0f} ticks and {run.measured:g} is too short; make it longer')
    if ticks * run.measured < 0.0:
        raise MotorBridgeError(
            f'in a {name} the encoders counted backwards; check signs, or swap the wires of motors and encoders'
        )
    if (run.left * run.right > 0.0) != (name == 'straight'):
        raise MotorBridgeError(
            f'in a {name} the wheels counted {run.left:.0f} and {run.right:.0f} ticks; repeat it or check the encoders'
        )


def _check_range(name: str, value: float, allowed: tuple[float, float]) -> None:
    if not allowed[0] <= value <= allowed[1]:
        raise MotorBridgeError(
            f'{name} is {value:.4g} m, which is implausible; check the measurements and ticks_per_revolution'
        )
