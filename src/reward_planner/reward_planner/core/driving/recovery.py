"""Recovery behaviors of a robot without a route: look around, wait, back up, clear the map, plan from scratch."""

import math
from collections.abc import Callable
from enum import Enum

import numpy as np

from reward_planner.core.driving.drive_state import DriveState, Velocity
from reward_planner.core.driving.path_following import CELL_MARGIN
from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED_THRESHOLD, UNKNOWN, GridFrame
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2, wrap_angle

RADIUS = 1.0
"""Radius of the surroundings, and least distance between two places of looking around [m]."""
_UNKNOWN_FRACTION = 0.5  # of the surroundings at which the robot looks around


class LookAround:
    """Decides when the robot looks around, and measures its turn."""

    def __init__(self, global_map: GlobalMap) -> None:
        """Start where nothing was looked at; the map is only read."""
        self._global_map = global_map
        self.reset()

    def reset(self) -> None:
        """Forget the places of looking around, for instance after the map was cleared."""
        self._places: list[SE2] = []
        self._checked: SE2 | None = None
        self._turned = math.inf  # a turn of less than 2 pi is under way [rad]

    def update(self, robot: SE2) -> bool:
        """Return whether the robot has to turn, given its pose in the map."""
        if self._turned < math.tau and self._checked is not None:
            self._turned += wrap_angle(self._checked.yaw_to(robot))
            self._checked = robot
            return self._turned < math.tau
        # Checked anew after each part of the radius.
        if self._checked is not None and self._checked.distance_to(robot) < 0.2 * RADIUS:
            return False
        self._checked = robot
        was_here = any(place.distance_to(robot) < RADIUS for place in self._places)
        if was_here or self._unknown_fraction(robot) < _UNKNOWN_FRACTION:
            return False
        self._places.append(robot)
        self._turned = 0.0
        return True

    def _unknown_fraction(self, robot: SE2) -> float:
        resolution = self._global_map.resolution
        cells = math.ceil(RADIUS / resolution)
        x, y = (resolution * (math.floor(number / resolution) - cells) for number in (robot.x, robot.y))
        frame = GridFrame(x, y, resolution, 2 * cells + 1, 2 * cells + 1)
        rows, columns = np.indices(frame.shape) - cells
        is_near = rows**2 + columns**2 <= cells**2
        return float((self._global_map.occupancy_in(frame)[is_near] == UNKNOWN).mean())


_START_TIME = 1.0  # time without a route before the first behavior [s]
_SETTLE_TIME = 1.0  # time for new frames after the map was cleared, and for a new route [s]
_LOOK_FRACTION = 0.5  # of the maximum turn rate: frames overlap
_BACK_SPEED = 0.1  # upper bound of the speed backwards [m/s]
_BACK_MARGIN = 0.03  # distance to stop from the speed backwards [m]
_STEP_MAX = 0.2  # upper bound of the time between two control cycles [s]
_NEW_PLACE = 0.5  # distance from the place of the last recovery at which all behaviors are allowed again [m]


class RecoveryBehavior(Enum):
    """A recovery behavior; the value is its name in the parameter ``recovery``."""

    LOOK_AROUND = 'look_around'
    WAIT = 'wait'
    BACK_UP = 'back_up'
    CLEAR = 'clear'
    REPLAN = 'replan'


def parse_recovery(names: str) -> tuple[RecoveryBehavior, ...]:
    """Return the behaviors of the parameter ``recovery``, names in their order; raise a DrivingError for another."""
    try:
        return tuple(RecoveryBehavior(name) for name in names.replace(',', ' ').split())
    except ValueError as fault:
        allowed = ', '.join(each.value for each in RecoveryBehavior)
        raise DrivingError(f'recovery is {names!r}; give names of {allowed}, in any order') from fault


class Recovery:
    """Runs the behaviors in the order of the settings until there is a route; each ends after a bounded time.

    All are allowed again at another place and for another goal.

    Attributes:
        behavior: the behavior that runs; None before the first and after the last.
        tried: behaviors since the last route at another place, and whether they were possible.
    """

    def __init__(self, clear: Callable[[SE2, float], None] | None, replan: Callable[[], None]) -> None:
        """Start without a behavior.

        Args:
            clear: clears the map around a pose within a radius [m]; None if that is not possible.
            replan: discards the route and plans from scratch.
        """
        self._clear, self._replan = clear, replan
        self.reset()

    def reset(self) -> None:
        """Allow all behaviors again, for another goal."""
        self.behavior: RecoveryBehavior | None = None
        self.tried: list[tuple[RecoveryBehavior, bool]] = []
        self._place: SE2 | None = None
        self._last = SE2(0.0, 0.0, 0.0)
        self._latest = math.nan
        self._elapsed = self._progress = 0.0

    @property
    def must_finish(self) -> bool:
        """Whether a route must not be followed yet: the map was cleared, and frames must restore what is there."""
        return self.behavior is RecoveryBehavior.CLEAR and self._elapsed < _SETTLE_TIME

    @property
    def detail(self) -> str:
        """What the robot does, one line."""
        name = 'stopping' if self.behavior is None else self.behavior.value.replace('_', ' ')
        return f'{DriveState.RECOVERING.value}: {name}'

    @property
    def summary(self) -> str:
        """Names of the behaviors that were tried in vain."""
        words = {True: '', False: ' (not possible)'}
        return ', '.join(f'{each.value}{words[done]}' for each, done in self.tried)

    def can_help(self, reason: NoRoute | None, route_count: int) -> bool:
        """Return whether recovery makes sense for a reason; not for a goal that was in an obstacle from the start."""
        if reason is NoRoute.GOAL_BLOCKED:
            return route_count > 0
        return reason not in (NoRoute.GOAL_OUTSIDE, NoRoute.START_OUTSIDE)

    def is_finished(self, settings: DrivingSettings) -> bool:
        """Return whether all behaviors were tried here."""
        return len(self.tried) >= len(parse_recovery(settings.recovery))

    def end(self, robot: SE2) -> None:
        """End the present behavior, as there is a route."""
        self.behavior, self._elapsed = None, 0.0
        if self._place is not None and self._place.distance_to(robot) > _NEW_PLACE:
            self.reset()

    def update(
        self, now: float, robot: SE2, known: GlobalMap, radius: float, settings: DrivingSettings, *, once: bool = False
    ) -> Velocity | None:
        """Return the velocity of the behavior for a robot without a route or stuck; None after the last one.

        Args:
            now: time [s].
            robot: pose in the map.
            known: map with all obstacles; the robot backs up on its free cells only.
            radius: radius of the robot [m].
            settings: behaviors and their limits.
            once: return None after each behavior, so that the robot tries its route in between.
        """
        step = now - self._latest
        self._elapsed += min(max(step, 0.0), _STEP_MAX) if math.isfinite(step) else 0.0
        self._latest = now
        if self._place is None:
            self._place = self._last = robot
        if self.behavior is None and self._elapsed < _START_TIME and not self.tried:
            return Velocity()
        velocity = None if self.behavior is None else self._run(self.behavior, robot, known, radius, settings)
        self._last = robot
        if once and velocity is None and self.behavior is not None:
            self.behavior, self._elapsed = None, 0.0
            return None
        while velocity is None:
            left = parse_recovery(settings.recovery)[len(self.tried) :]
            self.behavior, self._elapsed, self._progress = left[0] if left else None, 0.0, 0.0
            if self.behavior is None:
                return None
            if self.behavior is RecoveryBehavior.CLEAR and self._clear is not None:
                self._clear(robot, settings.recovery_radius)
            elif self.behavior is RecoveryBehavior.REPLAN:
                self._replan()
            velocity = self._run(self.behavior, robot, known, radius, settings)
            is_missing = self.behavior is RecoveryBehavior.CLEAR and self._clear is None
            self.tried.append((self.behavior, velocity is not None and not is_missing))
        return velocity

    def _run(
        self, behavior: RecoveryBehavior, robot: SE2, known: GlobalMap, radius: float, settings: DrivingSettings
    ) -> Velocity | None:
        """Return the velocity of a behavior, None at its end."""
        match behavior:
            case RecoveryBehavior.LOOK_AROUND:
                rate = _LOOK_FRACTION * settings.max_angular_velocity
                self._progress += wrap_angle(self._last.yaw_to(robot))
                is_done = self._progress >= math.tau or self._elapsed > 2.0 + 1.5 * math.tau / rate
                return None if is_done else Velocity(0.0, rate)
            case RecoveryBehavior.BACK_UP:
                speed = min(_BACK_SPEED, settings.max_linear_velocity)
                self._progress += self._last.distance_to(robot)
                left = settings.recovery_distance - self._progress
                left = min(left, free_distance_behind(known, robot, radius, left))
                is_late = self._elapsed > 2.0 + 2.0 * settings.recovery_distance / speed
                return None if is_late or left <= _BACK_MARGIN else Velocity(-speed)
            case RecoveryBehavior.WAIT:
                return None if self._elapsed >= settings.recovery_wait else Velocity()
            case _:
                # Longer than a route must wait, so that a route that was found is followed first.
                return None if self._elapsed >= _SETTLE_TIME + _STEP_MAX else Velocity()


def free_distance_behind(known: GlobalMap, robot: SE2, radius: float, distance_max: float) -> float:
    """Return how far a robot of a radius can drive straight backwards on free cells, up to a distance [m].

    Unknown cells are not free, except those under the robot.
    """
    resolution, reach = known.resolution, radius + CELL_MARGIN * known.resolution
    half = math.ceil((max(distance_max, 0.0) + reach) / resolution) + 1
    column, row = (math.floor(number / resolution) - half for number in (robot.x, robot.y))
    frame = GridFrame(column * resolution, row * resolution, resolution, 2 * half + 1, 2 * half + 1)
    values = known.occupancy_in(frame)
    cells = np.argwhere(values != FREE)
    x, y = (frame.centre_of(cells) - (robot.x, robot.y)).T
    behind = -(math.cos(robot.yaw) * x + math.sin(robot.yaw) * y)
    beside = np.abs(math.cos(robot.yaw) * y - math.sin(robot.yaw) * x)
    # The disc touches a cell after behind - sqrt(reach^2 - beside^2).
    is_other = (values[tuple(cells.T)] >= OCCUPIED_THRESHOLD) | (np.hypot(x, y) > radius)
    is_met = (behind > 0.0) & (beside < reach) & is_other
    distances = behind[is_met] - np.sqrt(reach**2 - beside[is_met] ** 2)
    return float(distances.min(initial=distance_max))
