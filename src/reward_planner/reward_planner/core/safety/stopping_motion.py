"""Motion of the base under a command and then braking, and contact with obstacles on the way."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.safety.footprint import polygon_distance

STEP = 0.025
"""Time step of the simulated motion [s]."""
_TOUCH = 1e-4  # an obstacle in the stop zone must not come nearer than this [m]


class BaseDynamics(NamedTuple):
    """How the base follows velocities: latency [s], deceleration [m/s^2] and angular deceleration [rad/s^2]."""

    latency: float
    deceleration: float
    angular_deceleration: float


class BaseMotion(NamedTuple):
    """Velocity of the base now, and the one that it was given last: forward [m/s] and turn rate [rad/s] of each."""

    forward: float
    turn_rate: float
    given_forward: float
    given_turn_rate: float


class Obstacles(NamedTuple):
    """Obstacle cells, predicted as discs that move and grow.

    Attributes:
        xy: positions in the base frame now, shape (n, 2) [m].
        velocity: shape (n, 2) [m/s].
        radius: radius now, shape (n,) [m].
        growth: growth of the radius, shape (n,) [m/s].
        is_static: static cells may be nearer than their radius, but not come nearer, shape (n,).
    """

    xy: NDArray[np.float64]
    velocity: NDArray[np.float64]
    radius: NDArray[np.float64]
    growth: NDArray[np.float64]
    is_static: NDArray[np.bool_]


@njit(cache=True)
def stopping_path(
    motion: BaseMotion, forward: float, turn_rate: float, hold: float, base: BaseDynamics
) -> NDArray[np.float64]:
    """Return x, y, yaw of the base until it has stopped, shape (n, 3), in its frame now; row 0 is now, one each STEP.

    The base follows the given velocity for the latency, then the new one for ``hold`` [s], then it brakes:
    a distance of v (latency + hold) + v^2 / (2 a) at constant speed v.
    """
    v, w, x, y, yaw, time = motion.forward, motion.turn_rate, 0.0, 0.0, 0.0, 0.0
    rows = [(x, y, yaw)]
    while time < base.latency + hold - 1e-9 or abs(v) + abs(w) > 1e-9:
        aim_v, aim_w = 0.0, 0.0
        if time < base.latency - 1e-9:
            aim_v, aim_w = motion.given_forward, motion.given_turn_rate
        elif time < base.latency + hold - 1e-9:
            aim_v, aim_w = forward, turn_rate
        before_v, before_w = v, w
        v += min(max(aim_v - v, -base.deceleration * STEP), base.deceleration * STEP)
        w += min(max(aim_w - w, -base.angular_deceleration * STEP), base.angular_deceleration * STEP)
        turn, way = 0.5 * (w + before_w) * STEP, 0.5 * (v + before_v) * STEP
        x += way * math.cos(yaw + 0.5 * turn)
        y += way * math.sin(yaw + 0.5 * turn)
        yaw += turn
        time += STEP
        rows.append((x, y, yaw))
    return np.array(rows)


@njit(cache=True)
def stopping_paths(
    motion: BaseMotion, command: tuple[float, float], fractions: NDArray[np.float64], hold: float,
    base: BaseDynamics,
) -> list[NDArray[np.float64]]:  # fmt: skip
    """Return the stopping path of each fraction of a command (forward, turn rate)."""
    return [stopping_path(motion, f * command[0], f * command[1], hold, base) for f in fractions]


@njit(cache=True)
def has_contact(path: NDArray[np.float64], corners: NDArray[np.float64], reach: float, obstacles: Obstacles) -> bool:
    """Return whether the disc of an obstacle meets the footprint on a path, at its begin, too.

    Args:
        path: x, y, yaw each STEP, shape (m, 3), as of `stopping_path`.
        corners: outline of the footprint, shape (k, 2) [m].
        reach: largest distance of a corner from the base frame's origin [m].
        obstacles: n predicted obstacles.
    """
    for i in range(len(obstacles.xy)):
        limit = math.inf
        if obstacles.is_static[i]:
            limit = polygon_distance(corners, obstacles.xy[i, 0], obstacles.xy[i, 1]) - _TOUCH
        for k in range(len(path)):
            x, y, yaw = path[k]
            time = k * STEP
            radius = min(obstacles.radius[i] + obstacles.growth[i] * time, limit)
            dx = obstacles.xy[i, 0] + obstacles.velocity[i, 0] * time - x
            dy = obstacles.xy[i, 1] + obstacles.velocity[i, 1] * time - y
            if math.hypot(dx, dy) > reach + radius:
                continue
            cos, sin = math.cos(yaw), math.sin(yaw)
            if polygon_distance(corners, cos * dx + sin * dy, cos * dy - sin * dx) < radius:
                return True
    return False
