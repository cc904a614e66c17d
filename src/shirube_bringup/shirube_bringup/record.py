"""Results of a mission: track, goals and zones, and time series for its report."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from scene_simulator.mission.layout import ROBOT_HEIGHT, ROBOT_RADIUS, ZONES, MissionLayout
from scene_simulator.mission.pedestrians import Place, solids_at
from scene_simulator.room.box_room import Box
from shirube_core.geometry import SE2

Array = NDArray[np.float64]
StampedNumbers = tuple[float, float, float, float]  # time [s], x [m], y [m], yaw [rad]

TRUE_ERROR_MAX, FUSED_ERROR_MAX = 0.03, 0.02
"""Limits of the distance of the robot from its goal, and of the fused pose error at a goal [m]."""


def as_array(poses: Sequence[StampedNumbers]) -> Array:
    """Return poses as an array, shape (n, 4): time, x, y, yaw."""
    return np.array(poses, dtype=np.float64).reshape(-1, 4)


def true_poses(truth: Array, times: Array) -> Array:
    """Return the true poses at times, shape (m,) [s], interpolated between those of shape (n, 4), shape (m, 4)."""
    columns = (truth[:, 1], truth[:, 2], np.unwrap(truth[:, 3]))
    return np.column_stack([times, *(np.interp(times, truth[:, 0], column) for column in columns)])


def pose_errors(poses: Array, truth: Array) -> tuple[Array, Array, Array]:
    """Return time [s], position error [m] and yaw error [rad] of each pose that is not before the first true pose."""
    poses = poses[poses[:, 0] >= truth[0, 0]]
    differences = poses - true_poses(truth, poses[:, 0])
    yaw_error = np.remainder(differences[:, 3] + np.pi, 2.0 * np.pi) - np.pi
    return poses[:, 0], np.hypot(differences[:, 1], differences[:, 2]), yaw_error


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
        poses: Mapping[str, Sequence[StampedNumbers]],
        commands: Sequence[tuple[float, str]],
        timing: Mapping[str, float],
    ) -> dict[str, object]:
        """Return the results without the track, as JSON data.

        Args:
            goals: number of goals of the mission.
            poses: poses of each localizer and of the arbiter, by name.
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
            'poses': {name: self._accuracy(stamped) for name, stamped in poses.items()},
            'zones': {zone: self._in_zone(zone, poses) for zone in ZONES},
            'timing': dict(timing),
        }

    def _accuracy(self, poses: Sequence[StampedNumbers]) -> dict[str, float]:
        _, errors, _ = pose_errors(as_array(poses), as_array(self.track))
        if not len(errors):
            return {'count': 0}
        rmse = float(np.sqrt(np.mean(errors**2)))
        return {'count': len(errors), 'rmse': rmse, 'median': float(np.median(errors)), 'worst': float(errors.max())}

    def _in_zone(self, zone: str, poses: Mapping[str, Sequence[StampedNumbers]]) -> dict[str, object]:
        inside, truth, found = ZONES[zone], as_array(self.track), dict[str, Array]()
        seconds = sum(b[0] - a[0] for a, b in pairwise(self.track) if inside.contains(a[1], a[2]))
        for name, stamped in poses.items():
            times, errors, _ = pose_errors(as_array(stamped), truth)
            places = true_poses(truth, times)[:, 1:3].tolist()
            found[name] = errors[[inside.contains(x, y) for x, y in places]]
        counts = {name: len(errors) for name, errors in found.items()}
        worst = float(found['pose_arbiter'].max(initial=0.0))
        return {'seconds': seconds, 'poses': counts, 'worst_fused_error': worst}
