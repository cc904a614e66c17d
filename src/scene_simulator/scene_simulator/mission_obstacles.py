"""Obstacles of the mission: low crates and tables that are not on the map, with a free path to each goal."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label

from scene_simulator.errors import SceneError
from scene_simulator.furnished_room import FurnishedRoom, Furnishing, furnish
from scene_simulator.mission_layout import ROBOT_HEIGHT, ROBOT_RADIUS, ROOM, MissionLayout

FURNISHING = Furnishing(crates=8, tables=3, racks=0, overhangs=0)
"""Nothing is higher than a meter: it hides neither lamps nor landmarks from the mast."""

PASSAGE = 0.25
"""Minimum clearance between the robot and obstacles on the path to the goals [m]."""

_CLEARANCE = 0.6
"""Clearance around start and goals [m]: room to turn."""
_CELL = 0.05
_TRIES = 100


def mission_obstacles(seed: int, layout: MissionLayout) -> FurnishedRoom:
    """Return the furnished room: the first one drawn in which all goals can be reached.

    Raises:
        SceneError: a negative seed, or no room was found.
    """
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
    solid = np.pad(
        room.boxes.solid_cells((0.0, 0.0), _CELL, shape, (0.0, ROBOT_HEIGHT)), 1, constant_values=True
    )
    distance = _CELL * distance_transform_edt(~solid)[1:-1, 1:-1]
    components, _ = label(distance > ROBOT_RADIUS + PASSAGE, structure=np.ones((3, 3)))
    return np.asarray(components, dtype=np.int32)
