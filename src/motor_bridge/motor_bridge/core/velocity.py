"""Velocity of the base, in the base frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

from motor_bridge.core.motor_bridge_error import MotorBridgeError

_VELOCITY_MAX = 1e6  # far above all limits, with finite squares [m/s, rad/s]


@dataclass(frozen=True)
class Velocity:
    """Velocity of a differential drive robot.

    Attributes:
        forward: linear velocity along x [m/s].
        turn_rate: angular velocity, counterclockwise [rad/s].
    """

    forward: float = 0.0
    turn_rate: float = 0.0


def check_velocity(forward: float, turn_rate: float) -> Velocity:
    """Return a commanded velocity after checking it.

    Raises:
        MotorBridgeError: a component is not finite or absurdly large.
    """
    if not (math.isfinite(forward) and math.isfinite(turn_rate)):
        raise MotorBridgeError('cmd_vel has a velocity that is not finite; check its publisher')
    if max(abs(forward), abs(turn_rate)) > _VELOCITY_MAX:
        raise MotorBridgeError('cmd_vel has a velocity that is implausibly high; check its publisher')
    return Velocity(forward, turn_rate)
