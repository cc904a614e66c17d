"""Results of a mission: track, goals and zones, and time series for its report."""

import json
import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise

import numpy as np

from scene_simulator.mission.layout import ROBOT_HEIGHT, ROBOT_RADIUS, ZONES, MissionLayout
from scene_simulator.mission.pedestrians import Place, solids_at
from scene_simulator.room.box_room import Box
from shirube_core.geometry import SE2

StampedNumbers = tuple[float, float, float, float]
"""Time [s], x [m], y [m], yaw [rad]."""

TRUE_ERROR_MAX, FUSED_ERROR_MAX = 0.03, 0.02
"""Limits of the distance of the robot from its goal, and of the fused pose error at a goal [m]."""


@dataclass(frozen=True)
class GridMap:
    """An occupancy grid of the planner.

    Attributes:
        corner: x and y of the lower left corner in the map frame [m].
        resolution: cell size [m].
        shape: number of rows (y) and columns (x).
        cells: occupancy in row-major order: -1 unknown, 0 free to 100 occupied.
    """

    corner: tuple[float, float]
    resolution: float
    shape: tuple[int, int]
    cells: Sequence[int]


@dataclass(frozen=True)
class StatusCount:
    """Cumulative number of poses of a source with a measurement status of the arbiter.

    Attributes:
        time: time of the count [s].
        source: name of the localizer.
        verdict: measurement status, as in the arbiter's diagnostics.
        count: number of poses since the start.
    """

    time: float
    source: str
    verdict: str
    count: int


@dataclass(frozen=True)
class MissionTraces:
    """Time series of a mission.

    Attributes:
        layout: start and goals.
        boxes: obstacles in the room.
        truth: true poses, every step.
        clearance: clearance around the robot in each step [m].
        poses: poses of each localizer, of the arbiter and of wheel odometry (which starts at 0), by name.
        legs: start and end time of each goal [s].
        trust: measurement status counts of the arbiter, once a second.
        map: last map of the planner.
        pace: simulated time and wall time since the start of the drive [s], about once a second.
        cpu: CPU time of each process during the drive [s].
        rates: nominal image rate of each camera, and published images per simulated second [1/s].
        people: places of all people in each step [m].
    """

    layout: MissionLayout
    boxes: tuple[Box, ...]
    truth: Sequence[StampedNumbers]
    clearance: Sequence[float]
    poses: Mapping[str, Sequence[StampedNumbers]]
    legs: Sequence[tuple[float, float]]
    trust: Sequence[StatusCount] = ()
    map: GridMap | None = None
    pace: Sequence[tuple[float, float]] = ()
    cpu: Mapping[str, float] = field(default_factory=dict)
    rates: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    people: Sequence[Sequence[tuple[float, float]]] = ()

    def as_json(self) -> str:
        """Return the traces as JSON text, with six decimals."""
        return json.dumps(json.loads(json.dumps(asdict(self)), parse_float=lambda text: round(float(text), 6)))

    @classmethod
    def from_json(cls, text: str) -> 'MissionTraces':
        """Return the traces that `as_json` wrote; raise a KeyError, TypeError or ValueError for other text."""
        data = json.loads(text)
        start, *goals = (SE2(**pose) for pose in (data['layout']['start'], *data['layout']['goals']))
        read = {
            'layout': MissionLayout(start, tuple(goals)),
            'trust': [StatusCount(**count) for count in data['trust']],
            'map': data['map'] and GridMap(**data['map']),
        }
        return cls(**{**data, **read})


@dataclass(frozen=True)
class GoalRecord:
    """Result of a goal.

    Attributes:
        reached: the planner reports the goal as reached and the robot is stationary.
        seconds: time since the goal was published [s].
        true_error: distance of the true pose from the goal [m].
        yaw_error: yaw error of the true pose at the goal [rad].
        fused_error: distance of the fused pose from the true pose at its stamp [m].
    """

    reached: bool
    seconds: float
    true_error: float
    yaw_error: float
    fused_error: float

    @property
    def is_good(self) -> bool:
        """Whether the goal was reached within the limits."""
        near = self.true_error <= TRUE_ERROR_MAX and self.fused_error <= FUSED_ERROR_MAX
        return self.reached and near


def count_collisions(clearances: Sequence[float]) -> int:
    """Return how often the robot begins to touch something, given its clearance in each step [m]."""
    return sum(now <= 0.0 < before for before, now in pairwise([1.0, *clearances]))


@dataclass
class MissionRecord:
    """Result of a mission.

    Attributes:
        seed: seed of the mission.
        goals: results of the goals, in order.
        track: time [s] and true x, y, yaw of each step [m, m, rad].
        clearances: clearance between robot and obstacles, people included, in each step [m].
        people_clearance: least clearance between robot and people [m].
        people: places of all people in each step [m].
        legs: start and end time of each goal [s].
        ended: reason why the mission ended.
        kidnapping: when the robot was carried away and had recovered [s], and time [s] and errors of the areas that the
            floor localizer was given [m, rad].
    """

    seed: int
    goals: list[GoalRecord] = field(default_factory=list)
    track: list[tuple[float, float, float, float]] = field(default_factory=list)
    clearances: list[float] = field(default_factory=list)
    people_clearance: float = math.inf
    people: list[list[tuple[float, float]]] = field(default_factory=list)
    legs: list[tuple[float, float]] = field(default_factory=list)
    ended: str = ''
    kidnapping: Mapping[str, object] = field(default_factory=dict)

    def add_step(self, time: float, pose: SE2, clearance: float, people: Sequence[Place] = ()) -> None:
        """Add the true pose at a time [s], the clearance to obstacles there [m] and the places of people [m]."""
        self.track.append((time, pose.x, pose.y, pose.yaw))
        to_people = solids_at(people).clearance(pose.x, pose.y, ROBOT_RADIUS, ROBOT_HEIGHT)
        self.clearances.append(min(clearance, to_people))
        self.people_clearance = min(self.people_clearance, to_people)
        self.people.append(list(people))

    def has_succeeded(self, goals: int) -> bool:
        """Return whether this number of goals was reached within the limits, without a collision."""
        return (
            len(self.goals) == goals
            and all(goal.is_good for goal in self.goals)
            and not count_collisions(self.clearances)
        )

    @property
    def path_length(self) -> float:
        """Path length of the robot [m]."""
        return sum(math.hypot(b[1] - a[1], b[2] - a[2]) for a, b in pairwise(self.track))

    def summary(
        self,
        goals: int,
        fixes: Mapping[str, Sequence[tuple[float, SE2]]],
        commands: Sequence[tuple[float, str]],
        timing: Mapping[str, float],
    ) -> dict[str, object]:
        """Return the results without the track, as JSON data.

        Args:
            goals: number of goals of the mission.
            fixes: time [s] and pose of all poses of each localizer and of the arbiter, by name.
            commands: time [s] and text of the commands of lamps.
            timing: durations by name [s].
        """
        return {
            'seed': self.seed,
            'success': self.has_succeeded(goals),
            'ended': self.ended,
            'kidnapping': dict(self.kidnapping),
            'goals': [{**asdict(goal), 'good': goal.is_good} for goal in self.goals],
            'collisions': count_collisions(self.clearances),
            'least_clearance': min(self.clearances, default=math.inf),
            'people': len(self.people[-1]) if self.people else 0,
            'least_clearance_to_people': self.people_clearance,
            'path_length': self.path_length,
            'seconds': self.track[-1][0] if self.track else 0.0,
            'orders': [{'time': time, 'order': command} for time, command in commands],
            'poses': {name: self._accuracy(poses) for name, poses in fixes.items()},
            'zones': {zone: self._in_zone(zone, fixes) for zone in ZONES},
            'timing': dict(timing),
        }

    def true_pose(self, time: float) -> SE2 | None:
        """Return the true pose at a time [s], interpolated; None before the first step."""
        after = bisect_right(self.track, time, key=lambda entry: entry[0])
        if after == 0:
            return None
        start, stop = self.track[after - 1], self.track[min(after, len(self.track) - 1)]
        fraction = (time - start[0]) / (stop[0] - start[0]) if stop[0] > start[0] else 0.0
        yaw_change = math.remainder(stop[3] - start[3], math.tau)
        x, y = (start[k] + fraction * (stop[k] - start[k]) for k in (1, 2))
        return SE2(x, y, start[3] + fraction * yaw_change)

    def _accuracy(self, poses: Sequence[tuple[float, SE2]]) -> dict[str, float]:
        errors = self._errors(poses, lambda _: True)
        if not errors:
            return {'count': 0}
        return {
            'count': len(errors),
            'rmse': float(np.sqrt(np.mean(np.square(errors)))),
            'median': float(np.median(errors)),
            'worst': max(errors),
        }

    def _in_zone(self, zone: str, fixes: Mapping[str, Sequence[tuple[float, SE2]]]) -> dict[str, object]:
        inside = ZONES[zone]
        seconds = sum(b[0] - a[0] for a, b in pairwise(self.track) if inside.contains(a[1], a[2]))
        counts = {
            name: len(self._errors(poses, lambda pose: inside.contains(pose.x, pose.y)))
            for name, poses in fixes.items()
        }
        worst = self._errors(fixes['pose_arbiter'], lambda pose: inside.contains(pose.x, pose.y))
        return {'seconds': seconds, 'poses': counts, 'worst_fused_error': max(worst, default=0.0)}

    def _errors(self, poses: Sequence[tuple[float, SE2]], is_selected: Callable[[SE2], bool]) -> list[float]:
        """Return the position errors [m] of the poses whose true pose satisfies a condition."""
        pairs = ((pose, self.true_pose(time)) for time, pose in poses)
        return [pose.distance_to(truth) for pose, truth in pairs if truth is not None and is_selected(truth)]
