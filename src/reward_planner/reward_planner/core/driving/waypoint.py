"""The point of the route for which the robot heads, and what lies free on the way to it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drivable_area import DrivableArea
from shirube_geometry import PlanarPose

_SAMPLES_A_CELL = 2.0
_OUT_WITHIN = 1.5  # a robot that stands on an obstacle may go on if it is off it so soon [cells]


def next_waypoint(
    area: DrivableArea, robot: PlanarPose, points_map: NDArray[np.float64], lookahead: float
) -> NDArray[np.float64]:
    """Return the farthest point of the route within reach to which the robot can go straight, shape (2,) [m].

    So the corners of a route of cells are cut where they may be. On the straight line the robot comes no nearer to
    obstacles than a route does, or than it is now. Where no point can be seen it is the route's next one.

    Args:
        area: which knows how near obstacles are.
        robot: where the robot is.
        points_map: shape (n, 2), the route from about the robot on, n at least 1 [m].
        lookahead: how far along the route [m].
    """
    along = np.cumsum(np.hypot(*np.diff(points_map, axis=0, prepend=points_map[:1]).T))
    near = points_map[: max(1, int(np.searchsorted(along, lookahead)) + 1)]
    start = np.array([robot.x, robot.y])
    share = np.linspace(0.0, 1.0, _samples(area, lookahead + float(np.hypot(*(near[0] - start)))))
    lines = start + share[:, None] * (near - start)[:, None]
    least = min(area.keep_away, float(area.clearance_at(start)))
    # A point where the robot is gives no direction: a route that comes back there would let it spin.
    is_apart = np.hypot(*(near - start).T) >= area.frame.resolution
    seen = is_apart & (area.clearance_at(lines).min(axis=1) >= least)
    nearest = min(1, len(near) - 1)
    return np.asarray(near[int(np.flatnonzero(seen)[-1]) if seen[nearest:].any() else nearest])


def free_ahead(area: DrivableArea, robot: PlanarPose, keep_away: float, reach: float) -> tuple[float, float]:
    """Return how far the robot can go straight ahead, and the least clearance on that way [m].

    Args:
        area: which knows how near obstacles are.
        robot: where the robot is.
        keep_away: distance from obstacles at which the way ends, or that of now where it is less [m].
        reach: no farther than this [m].
    """
    distances = np.linspace(0.0, reach, _samples(area, reach))
    ahead = np.array([math.cos(robot.yaw), math.sin(robot.yaw)])
    clearance = area.clearance_at((robot.x, robot.y) + distances[:, None] * ahead)
    ends = clearance < min(keep_away, float(clearance[0]))
    ends |= (clearance <= 0.0) & (distances > _OUT_WITHIN * area.frame.resolution)
    free = int(ends.argmax()) if ends.any() else len(distances)
    return float(distances[max(free - 1, 0)]), float(clearance[:free].min())


def _samples(area: DrivableArea, distance: float) -> int:
    return 2 + int(_SAMPLES_A_CELL * distance / area.frame.resolution)
