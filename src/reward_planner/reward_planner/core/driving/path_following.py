"""Path following: the lookahead point on the route, the free distance ahead, steering and speed limits."""

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.driving.drive_state import DriveCommand, DriveState, Velocity, stop_command
from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.mapping.global_map import CostmapMasks
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2

CELL_MARGIN = 0.75
"""From the centre of an occupied cell to its edge, rounded up [cells]."""
_SAMPLES_PER_CELL = 2.0
_EXIT_DISTANCE = 1.5  # a robot on an occupied cell may drive on if it leaves it within this distance [cells]
_KEPT_FRACTION = 0.5  # of the clearance that a route keeps above the least one
_GAIN = 0.2  # clearance that a robot with too little must gain on its way [m/m]
_HEADING_TIME_CONSTANT = 0.4  # time constant of the heading error [s]
_BRAKE_FRACTION = 0.5  # fraction of the maximum acceleration that is planned for braking
_RESPONSE_TIME = 0.15  # latency from a pose to the motion of the wheels [s]
_DRIVE_BEARING_MAX = 0.6  # above this bearing the robot turns in place [rad]
_HELD_BEARING_MAX = 0.1  # the same for a robot that was held [rad]
_SLOWEST_FRACTION = 0.25  # minimum speed near obstacles, fraction of the maximum speed
_SLOWEST = 0.1  # upper bound of the minimum speed near obstacles [m/s]


def lookahead_point(
    costmap: InflatedCostmap, robot: SE2, points_map: NDArray[np.float64], lookahead: float
) -> NDArray[np.float64]:
    """Return the farthest point of the route within the lookahead distance in line of sight, shape (2,) [m].

    This cuts the corners of a grid route where there is room. The line of sight keeps the costmap's inscribed radius
    and half of what the route keeps above it, from obstacles and, for itself, from these and unknown cells behind them:
    a route near what is only unknown must not lead past an obstacle as near. From a robot with less it must gain
    clearance. If no point is in line of sight, it is the route's next point.
    The route begins near the robot [m], shape (n, 2), n at least 1.
    """
    along = np.cumsum(np.hypot(*np.diff(points_map, axis=0, prepend=points_map[:1]).T))
    candidates = points_map[: max(1, int(np.searchsorted(along, lookahead)) + 1)]
    start = np.array([robot.x, robot.y])
    fractions = np.linspace(0.0, 1.0, _sample_count(costmap, lookahead + float(np.hypot(*(candidates[0] - start)))))
    lines = start + fractions[:, None] * (candidates - start)[:, None]
    # A point at the robot gives no direction: on a route that returns there the robot would spin.
    is_visible = np.hypot(*(candidates - start).T) >= costmap.frame.resolution
    for is_cautious in (False, True):
        clearance = partial(costmap.clearance_at, is_cautious=is_cautious)
        kept = np.minimum.accumulate(clearance(candidates)) - costmap.inscribed_radius
        clearance_min = costmap.inscribed_radius + np.where(kept > 0.0, _KEPT_FRACTION * kept, kept)
        gained = clearance(start) + _GAIN * np.hypot(*np.moveaxis(lines - start, 2, 0))
        is_visible &= (clearance(lines) >= np.minimum(clearance_min[:, None], gained)).all(axis=1)
    nearest = min(1, len(candidates) - 1)
    return np.asarray(candidates[int(np.flatnonzero(is_visible)[-1]) if is_visible[nearest:].any() else nearest])


def check_path_ahead(
    costmap: InflatedCostmap, robot: SE2, inflation_radius: float, distance_max: float
) -> tuple[float, float]:
    """Return the free distance straight ahead, up to ``distance_max``, and the least clearance along it [m].

    The path ends at a clearance of ``inflation_radius``, or of the present clearance if that is less [m].
    """
    distances = np.linspace(0.0, distance_max, _sample_count(costmap, distance_max))
    ahead = np.array([math.cos(robot.yaw), math.sin(robot.yaw)])
    clearance = costmap.clearance_at((robot.x, robot.y) + distances[:, None] * ahead)
    is_blocked = clearance < min(inflation_radius, float(clearance[0]))
    is_blocked |= (clearance <= 0.0) & (distances > _EXIT_DISTANCE * costmap.frame.resolution)
    free_count = int(is_blocked.argmax()) if is_blocked.any() else len(distances)
    return float(distances[max(free_count - 1, 0)]), float(clearance[:free_count].min())


def _sample_count(costmap: InflatedCostmap, distance: float) -> int:
    return 2 + int(_SAMPLES_PER_CELL * distance / costmap.frame.resolution)


def turn_rate_for_angle(angle: float, settings: DrivingSettings) -> float:
    """Return the turn rate for a remaining angle [rad/s]; it decelerates without overshoot."""
    brake = math.sqrt(2.0 * _BRAKE_FRACTION * settings.max_angular_acceleration * abs(angle))
    rate = min(brake, abs(angle) / _HEADING_TIME_CONSTANT, settings.max_angular_velocity)
    return math.copysign(rate, angle)


def velocity_towards(bearing: float, speed: float, settings: DrivingSettings, *, is_held: bool = False) -> Velocity:
    """Return the velocity towards a point at a bearing [rad]; ``speed`` is that at zero bearing [m/s].

    A robot that is held by an obstacle beside it turns away before it drives.
    """
    forward = speed * max(0.0, 1.0 - abs(bearing) / (_HELD_BEARING_MAX if is_held else _DRIVE_BEARING_MAX))
    return Velocity(forward, turn_rate_for_angle(bearing, settings))


def braking_speed_limit(distance: float, settings: DrivingSettings) -> float:
    """Return the maximum speed from which the robot can stop within a distance [m]: [m/s]."""
    acceleration = _BRAKE_FRACTION * settings.max_linear_acceleration
    delay = settings.max_linear_acceleration / settings.max_linear_jerk + _RESPONSE_TIME
    # Solve v delay + v^2 / (2 a) = distance for v.
    return acceleration * (math.sqrt(delay**2 + 2.0 * max(distance, 0.0) / acceleration) - delay)


def mask_speed_limit(
    masks: CostmapMasks, robot: SE2, points_map: NDArray[np.float64], settings: DrivingSettings
) -> float:
    """Return the speed [m/s] from which the robot brakes to that of a mask before its zone on the route, (n, 2) [m]."""
    top, acceleration = settings.max_linear_velocity, _BRAKE_FRACTION * settings.max_linear_acceleration
    limit = masks.speed_limit(robot.x, robot.y, top)
    if masks.speed is None:
        return limit
    for x, y in points_map.tolist():
        slow = masks.speed_limit(x, y, top)
        if slow < limit:
            distance = math.hypot(x - robot.x, y - robot.y) - masks.speed.grid.frame.resolution
            limit = min(limit, max(slow, braking_speed_limit(distance + 0.5 * slow**2 / acceleration, settings)))
    return limit


def obstacle_speed_limit(gap: float, settings: DrivingSettings) -> float:
    """Return the maximum speed [m/s] at a gap between the robot's edge and the nearest obstacle [m]."""
    fastest = settings.max_linear_velocity
    slowest = min(_SLOWEST, _SLOWEST_FRACTION * fastest)
    return max(slowest, fastest * min(1.0, gap / settings.slow_distance))


def route_speed_limit(
    costmap: InflatedCostmap,
    robot: SE2,
    robot_radius: float,
    points_map: NDArray[np.float64],
    distance_max: float,
    settings: DrivingSettings,
) -> float:
    """Return the speed that obstacles up to a distance straight ahead [m], and the end of the route, allow [m/s]."""
    radius = robot_radius + CELL_MARGIN * costmap.frame.resolution
    free_distance, clearance = check_path_ahead(costmap, robot, radius, distance_max)
    # The nearest point may be behind the robot; the next one is ahead.
    ahead = points_map[min(1, len(points_map) - 1) :]
    to_goal = float(np.hypot(*np.diff(ahead, axis=0).T).sum()) + math.hypot(*(ahead[0] - (robot.x, robot.y)))
    return min(
        obstacle_speed_limit(clearance - robot_radius, settings),
        braking_speed_limit(free_distance, settings) if free_distance < distance_max else math.inf,
        braking_speed_limit(to_goal, settings),
    )


_ENTER_FACTOR = 0.7  # within this multiple of goal_tolerance the robot turns to the goal's heading
_LEAVE_FACTOR = 2.0  # beyond this multiple of goal_tolerance it drives to the goal again


class GoalArrival:
    """Whether the robot is at its goal, with hysteresis while it turns to the goal's heading."""

    def __init__(self) -> None:
        """Start before the goal."""
        self._is_at_goal = False

    def update(self, robot: SE2, goal: SE2, settings: DrivingSettings) -> DriveCommand | None:
        """Return the turn to the goal's heading, or the stop after it; None before the goal."""
        remaining = robot.yaw_to(goal)
        is_turned = abs(remaining) <= settings.goal_yaw_tolerance
        leave = 1.0 if is_turned else _LEAVE_FACTOR
        factor = leave if self._is_at_goal else _ENTER_FACTOR
        self._is_at_goal = robot.distance_to(goal) <= settings.goal_tolerance * factor
        if not self._is_at_goal:
            return None
        if is_turned:
            return stop_command(DriveState.GOAL_REACHED)
        turn = Velocity(0.0, turn_rate_for_angle(remaining, settings))
        return DriveCommand(DriveState.DRIVING, "turning to the goal's heading", turn)
