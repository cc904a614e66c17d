"""Velocities of the base frame in itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

from motor_bridge.core.motor_bridge_error import MotorBridgeError

_FASTEST = 1e6  # far beyond all limits, and squares of it are still finite [m/s, rad/s]


@dataclass(frozen=True)
class Velocity:
    """How fast a robot on two driven wheels moves.

    Attributes:
        forward: [m/s].
        turn_rate: counterclockwise [rad/s].
    """

    forward: float = 0.0
    turn_rate: float = 0.0


def finite_velocity(forward: float, turn_rate: float) -> Velocity:
    """Return a velocity that somebody commands.

    Raises:
        MotorBridgeError: a number that is not finite, or of no robot.
    """
    if not (math.isfinite(forward) and math.isfinite(turn_rate)):
        raise MotorBridgeError('cmd_vel holds a velocity that is not finite; check its publisher')
    if max(abs(forward), abs(turn_rate)) > _FASTEST:
        raise MotorBridgeError('cmd_vel holds a velocity that no robot has; check its publisher')
    return Velocity(forward, turn_rate)
