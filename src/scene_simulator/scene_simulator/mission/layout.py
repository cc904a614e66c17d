"""The mission: start, goals, obstacles, and the zones in which one localizer has no measurements.

The room's lower left corner is the origin of the map. The building is always the same; the seed decides the furniture
and the exact start and goals.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from scene_simulator.errors import SceneError, check_seed
from scene_simulator.room.box_room import Box
from scene_simulator.room.furniture import FurnishedRoom, Furnishing, furnish
from shirube_core.geometry import SE2

ROOM: Box = (0.0, 0.0, 0.0, 8.0, 6.0, 3.2)
"""Corners of the room in the map frame [m]."""

ROBOT_RADIUS, ROBOT_HEIGHT = 0.2, 1.3
"""Radius and height of the robot's bounding cylinder, mast included [m]."""

_START = SE2(0.9, 1.1, 0.0)
_GOALS = (SE2(5.8, 1.2, 0.0), SE2(6.4, 3.8, 0.5 * math.pi), SE2(2.2, 4.6, math.pi))
"""Each faces a wall with landmarks, 2.2 m before it."""

_MAX_SHIFT, _MAX_ROTATION = 0.1, math.radians(4.0)
"""Maximum random shift and rotation of start and goals [m, rad]."""

_LAYOUT = 11
FURNISHING = Furnishing(crates=8, tables=3, racks=0, overhangs=0)
"""Nothing is higher than a meter: it hides neither lamps nor landmarks from the mast."""

PASSAGE = 0.25
"""Minimum clearance between the robot and obstacles on the path to the goals [m]."""

_CLEARANCE = 0.6
"""Clearance around start and goals [m]: room to turn."""

_CELL = 0.05
_TRIES = 100


@dataclass(frozen=True)
class Zone:
    """A rectangle on the floor.

    Attributes:
        low: its lower left corner [m].
        high: its upper right corner [m].
    """

    low: tuple[float, float]
    high: tuple[float, float]

    def contains(self, x: float, y: float) -> bool:
        """Return whether a place [m] is in it."""
        return self.low[0] <= x <= self.high[0] and self.low[1] <= y <= self.high[1]


CARPET = Zone((4.4, 0.4), (7.0, 2.0))
"""A carpet hides the floor's dots."""

DARK = Zone((5.4, 3.0), (7.4, 4.6))
"""No lamp is visible here: those above are off."""

COVERED = Zone((1.4, 3.8), (4.8, 5.4))
"""The landmarks of the west wall are hidden by a curtain here."""

ZONES = {'carpet': CARPET, 'dark': DARK, 'covered': COVERED}
"""The zones by name: without floor dots, without lamps, without landmarks."""


@dataclass(frozen=True)
class MissionLayout:
    """Start and goals.

    Attributes:
        start: ``T_map_base`` at the beginning.
        goals: the poses that the robot is to reach, in this order.
    """

    start: SE2
    goals: tuple[SE2, ...]


NOMINAL = MissionLayout(_START, _GOALS)
"""Start and goals as the places were taught for them."""


def mission_layout(seed: int) -> MissionLayout:
    """Return start and goals of a seed, each a little off the nominal pose."""
    check_seed(seed)
    rng = np.random.default_rng((seed, _LAYOUT))
    start, *goals = (_perturb(pose, rng) for pose in (_START, *_GOALS))
    return MissionLayout(start, tuple(goals))


def _perturb(pose: SE2, rng: np.random.Generator) -> SE2:
    x, y, turn = rng.uniform(-1.0, 1.0, 3).tolist()
    return SE2(pose.x + _MAX_SHIFT * x, pose.y + _MAX_SHIFT * y, pose.yaw + _MAX_ROTATION * turn)


def mission_obstacles(seed: int, layout: MissionLayout) -> FurnishedRoom:
    """Return the furnished room: the first one drawn in which all goals can be reached, or raise SceneError."""
    stops = [(pose.x, pose.y) for pose in (layout.start, *layout.goals)]
    for attempt in range(_TRIES):
        room = furnish(ROOM, FURNISHING, _TRIES * seed + attempt, stops, _CLEARANCE)
        if is_connected(room, stops):
            return room
    raise SceneError(f'no room of seed {seed} has a free path to all goals; use another seed')


def is_connected(room: FurnishedRoom, stops: list[tuple[float, float]]) -> bool:
    """Return whether the robot can drive from each of some places [m] to all others."""
    components = _connected_components(room)
    found = {int(components[math.floor(y / _CELL), math.floor(x / _CELL)]) for x, y in stops}
    return len(found) == 1 and 0 not in found


def _connected_components(room: FurnishedRoom) -> NDArray[np.int32]:
    """Return the number of the connected part of each cell, 0 for cells that are too near to something."""
    shape = round(ROOM[4] / _CELL), round(ROOM[3] / _CELL)
    solid = np.pad(room.boxes.solid_cells((0.0, 0.0), _CELL, shape, (0.0, ROBOT_HEIGHT)), 1, constant_values=True)
    distance = _CELL * distance_transform_edt(~solid)[1:-1, 1:-1]
    components, _ = label(distance > ROBOT_RADIUS + PASSAGE, structure=np.ones((3, 3)))
    return np.asarray(components, dtype=np.int32)
