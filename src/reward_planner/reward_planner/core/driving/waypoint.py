"""The lookahead point on the route, and the free distance ahead of the robot."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drivable_area import DrivableArea
from shirube_geometry import PlanarPose

_SAMPLES_A_CELL = 2.0
_OUT_WITHIN = 1.5  # a robot on an occupied cell may drive on if it leaves it within this distance [cells]


def next_waypoint(
    area: DrivableArea, robot: PlanarPose, points_map: NDArray[np.float64], lookahead: float
) -> NDArray[np.float64]:
    """Return the farthest point of the route within the lookahead distance in line of sight, shape (2,) [m].

    This cuts the corners of a grid route where there is room. The line of sight keeps the costmap's inflation radius,
    or the robot's present clearance if that is less. If no point is in line of sight, it is the route's next point.

    Args:
        costmap: clearance around the robot.
        robot: pose of the robot in the map.
        points_map: route from near the robot on [m], shape (n, 2), n at least 1.
        lookahead: lookahead distance along the route [m].
    """
    along = np.cumsum(np.hypot(*np.diff(points_map, axis=0, prepend=points_map[:1]).T))
    near = points_map[: max(1, int(np.searchsorted(along, lookahead)) + 1)]
    start = np.array([robot.x, robot.y])
    share = np.linspace(0.0, 1.0, _samples(area, lookahead + float(np.hypot(*(near[0] - start)))))
    lines = start + share[:, None] * (near - start)[:, None]
    least = min(area.keep_away, float(area.clearance_at(start)))
    # A point at the robot gives no direction: on a route that returns there the robot would spin.
    is_apart = np.hypot(*(near - start).T) >= area.frame.resolution
    seen = is_apart & (area.clearance_at(lines).min(axis=1) >= least)
    nearest = min(1, len(near) - 1)
    return np.asarray(near[int(np.flatnonzero(seen)[-1]) if seen[nearest:].any() else nearest])


def free_ahead(area: DrivableArea, robot: PlanarPose, keep_away: float, reach: float) -> tuple[float, float]:
    """Return the free distance straight ahead of the robot, and the least clearance along it [m].

    Args:
        costmap: clearance around the robot.
        robot: pose of the robot in the map.
        inflation_radius: clearance at which the path ends, or the present clearance if that is less [m].
        distance_max: largest distance to check [m].
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
