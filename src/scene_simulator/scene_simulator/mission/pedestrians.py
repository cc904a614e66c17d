"""People who walk to and fro in the mission's room, and wait while the robot is in their way."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from scene_simulator.errors import SceneError
from scene_simulator.mission.layout import CELL, ROOM, MissionLayout, free_distances
from scene_simulator.room.box_room import Cylinder, Solids
from scene_simulator.room.furniture import FurnishedRoom
from shirube_core.geometry import SE2

KINDS = ('person', 'legs', 'child', 'group', 'wheelchair', 'trolley', 'lying body', 'standing body')
"""What a `Walker` can be; the two test bodies are 200 mm x 600 mm and 70 mm x 400 mm."""
_LEG_OFFSET, _LEG_RADIUS, _LEG_HEIGHT = 0.1, 0.06, 0.85
_GROUP = ((0.0, 0.0), (-0.3, 0.6), (-0.1, -0.6))
"""Places of three people who walk together, along and across their way [m]."""
_UPRIGHT = {
    'person': (_GROUP[:1], 0.22, 1.75),
    'group': (_GROUP, 0.22, 1.75),
    'child': (_GROUP[:1], 0.12, 0.9),
    'standing body': (_GROUP[:1], 0.035, 0.4),
}
"""Places, radius and height of upright bodies [m]."""


@dataclass(frozen=True)
class Walker:
    """Somebody who walks straight on, whatever is in the way.

    Attributes:
        kind: one of `KINDS`.
        start: pose at time 0, the way is along x.
        speed: walking speed [m/s].

    Raises:
        SceneError: an unknown kind.
    """

    kind: str
    start: SE2
    speed: float

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SceneError(f'{self.kind!r} does not walk here; give one of {", ".join(KINDS)}')

    def pose_at(self, time: float) -> SE2:
        """Return the pose at a time [s]."""
        return self.start @ SE2(self.speed * time, 0.0, 0.0)

    def solids_at(self, time: float) -> Solids:
        """Return the body at a time [s]."""
        pose = self.pose_at(time)
        if self.kind == 'legs':
            return self._legs(pose, time)
        if self.kind == 'trolley':
            pushed = Solids(boxes=((pose.x, pose.y, pose.yaw, 0.4, 0.25, 0.1, 0.95),))
            return pushed + self._legs(pose @ SE2(-0.75, 0.0, 0.0), time)
        if self.kind == 'wheelchair':
            chair = Solids(boxes=((pose.x, pose.y, pose.yaw, 0.5, 0.32, 0.1, 0.55),))
            return chair + _upright(pose @ SE2(-0.15, 0.0, 0.0), 0.2, 0.55, 1.3)
        if self.kind == 'lying body':
            a, b = pose @ SE2(0.0, -0.3, 0.0), pose @ SE2(0.0, 0.3, 0.0)
            return Solids(((a.x, a.y, 0.1, b.x, b.y, 0.1, 0.1),))
        places, radius, height = _UPRIGHT[self.kind]
        people = [_upright(pose @ SE2(x, y, 0.0), radius, 0.0, height) for x, y in places]
        return sum(people, Solids())

    def _legs(self, pose: SE2, time: float) -> Solids:
        """Return legs of which one rests while the other swings at twice the speed, and the body above."""
        period = 1.4 - 0.35 * min(self.speed, 1.6)
        legs = list[Cylinder]()
        for side, phase in ((_LEG_OFFSET, 0.0), (-_LEG_OFFSET, 0.5)):
            turn = (time / period + phase) % 1.0
            ahead = 0.25 - turn if turn < 0.5 else turn - 0.75
            foot = pose @ SE2(self.speed * period * ahead, side, 0.0)
            legs.append((foot.x, foot.y, 0.0, foot.x, foot.y, _LEG_HEIGHT, _LEG_RADIUS))
        return Solids(tuple(legs)) + _upright(pose, 0.18, _LEG_HEIGHT, 1.75)


def _upright(pose: SE2, radius: float, low: float, high: float) -> Solids:
    return Solids(((pose.x, pose.y, low, pose.x, pose.y, high, radius),))


RADIUS, HEIGHT = 0.22, 1.75  # radius and height of an upright person [m]
Place = tuple[float, float]  # x, y in the map frame [m]
_CLEARANCE = 0.35  # clearance of a way from furniture and walls, from the person's middle [m]
_LENGTH_MIN, _SPEEDS = 2.5, (0.5, 1.3)  # least length of a way [m], range of the walking speeds [m/s]
_PERSONAL_SPACE, _AHEAD = 0.85, math.radians(70.0)
"""A person waits for a robot as near as this from middle to middle [m], and within this angle of the way [rad]."""
_TURN_AFTER = 2.0  # a person who waited this long turns round [s]
_STOP_DISTANCE = 0.8  # least distance of a way from the robot's start and goals [m]
_STREAM, _TRIES = 12, 2000


@dataclass
class Pedestrian:
    """A person on a straight way between two places.

    Attributes:
        start, end: where the person turns round.
        speed: walking speed [m/s].
        distance: distance from the start [m].
        direction: 1 towards the end, -1 back.
    """

    start: Place
    end: Place
    speed: float
    distance: float = 0.0
    direction: float = 1.0
    _waited: float = 0.0

    @property
    def length(self) -> float:
        """Length of the way [m]."""
        return math.dist(self.start, self.end)

    @property
    def place(self) -> Place:
        """Where the person is [m]."""
        share = self.distance / self.length
        x, y = (a + share * (b - a) for a, b in zip(self.start, self.end, strict=True))
        return x, y

    def advance(self, elapsed: float, robot: SE2) -> None:
        """Walk for a time [s], or wait for the robot."""
        if self._is_blocked_by(robot):
            self._waited += elapsed
            if self._waited > _TURN_AFTER:
                self.direction, self._waited = -self.direction, 0.0
            return
        self._waited = 0.0
        self.distance += self.direction * self.speed * elapsed
        if not 0.0 < self.distance < self.length:
            self.distance = min(max(self.distance, 0.0), self.length)
            self.direction = 1.0 if self.distance == 0.0 else -1.0

    def _is_blocked_by(self, robot: SE2) -> bool:
        (x, y), way = self.place, np.subtract(self.end, self.start) * self.direction
        to_robot = np.array([robot.x - x, robot.y - y])
        gap = float(np.hypot(*to_robot))
        return gap < _PERSONAL_SPACE and float(way @ to_robot) > math.cos(_AHEAD) * gap * self.length


def mission_pedestrians(seed: int, count: int, room: FurnishedRoom, layout: MissionLayout) -> list[Pedestrian]:
    """Return people of a seed on ways without furniture, or raise a SceneError if there are none."""
    rng, found = np.random.default_rng((seed, _STREAM)), list[Pedestrian]()
    is_free = free_distances(room, HEIGHT) > _CLEARANCE
    stops = np.array([(pose.x, pose.y) for pose in (layout.start, *layout.goals)])
    for _ in range(_TRIES):
        if len(found) == count:
            return found
        start, end = rng.uniform(ROOM[:2], ROOM[3:5], (2, 2))
        speed = rng.uniform(*_SPEEDS)
        steps = np.linspace(start, end, math.ceil(math.dist(start, end) / CELL) + 2)
        columns, rows = np.floor(steps / CELL).astype(np.int64).T
        is_far = cdist(steps, stops).min() > _STOP_DISTANCE
        if math.dist(start, end) >= _LENGTH_MIN and is_far and is_free[rows, columns].all():
            found.append(Pedestrian((start[0], start[1]), (end[0], end[1]), speed))
    if len(found) == count:
        return found
    raise SceneError(f'the room of seed {seed} has no ways for {count} people; use another seed or fewer people')


def solids_at(places: Sequence[Place]) -> Solids:
    """Return the bodies of people at some places."""
    return sum((Walker('person', SE2(x, y, 0.0), 0.0).solids_at(0.0) for x, y in places), Solids())
