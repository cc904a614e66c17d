"""Walls, landmarks and obstacles of the mission, as the stereo cameras see them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor.drawing import Drawing
from scene_simulator.corridor.fittings import NoticeBoard, RoundSign, Sign
from scene_simulator.corridor.instruments import Cabinet, Meter
from scene_simulator.corridor.scene import CorridorScene, Occluder, SceneObject
from scene_simulator.corridor.shapes import CorridorLight, FlatShape, Landmark, Paint, ShapeTable, Surface, shape_table
from scene_simulator.corridor.walls import RoomShell
from scene_simulator.mission.layout import ROOM
from scene_simulator.room.box_room import Box

_GRAIN = 0.08
_EDGE = 0.012  # width of the worn edges of a box [m]
_TOP, _SIDES = 1.15, (0.8, 0.95)  # brightness of the top, and of the sides across x and y, relative to the paint
_BUILDING_SEED = 41  # seed of the landmark positions: the building is always the same
_LIGHT = CorridorLight(0.9, (0.0, 0.0, 0.06))
_WALLS = {'east': (4.8, 'EXIT', 'PUMP 1'), 'north': (6.4, 'ROOM 204', 'VALVES'), 'west': (4.6, 'LEVEL 2', 'NO ENTRY')}
"""Centre of the landmarks from the wall's left end [m] and the texts of the signs, by wall."""

_CURTAIN = (3.4, 1.9)  # width and height of the curtain over the west wall's landmarks [m]
_GREYS = 0.3, 0.75  # range of the reflectance of crates and tables


def box_shapes(box: Box, grey: float) -> list[FlatShape]:
    """Return the top and the four sides of a box of a grey, 0 to 1; a painter leaves out those turned away."""
    x0, y0, z0, x1, y1, z1 = box
    wide, deep, high = x1 - x0, y1 - y0, z1 - z0
    faces = (
        (Surface((x0, y1, z0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)), (deep, high), _SIDES[0]),
        (Surface((x1, y0, z0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (deep, high), _SIDES[0]),
        (Surface((x0, y0, z0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), (wide, high), _SIDES[1]),
        (Surface((x1, y1, z0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), (wide, high), _SIDES[1]),
        (Surface((x0, y0, z1), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)), (wide, deep), _TOP),
    )
    shapes = []
    for surface, (right, up), shade in faces:
        drawing = Drawing(surface)
        drawing.rectangle((0.0, 0.0), (right, up), Paint(0.6 * shade * grey))
        inner = min(_EDGE, 0.25 * right, 0.25 * up)
        body = Paint(shade * grey, _GRAIN, 1.0, (x0, y0))
        drawing.rectangle((inner, inner), (right - inner, up - inner), body)
        shapes += drawing.shapes
    return shapes


def sort_farthest_first(boxes: Iterable[Box], camera_position: NDArray[np.float64]) -> list[Box]:
    """Return boxes that do not overlap in the order in which they are painted, by their nearest points."""

    def distance(box: Box) -> float:
        corners = np.array(box)
        return float(np.linalg.norm(np.clip(camera_position, corners[:3], corners[3:]) - camera_position))

    return sorted(boxes, key=distance, reverse=True)


def bare_walls() -> CorridorScene:
    """Return the walls as they were when the places were taught: no obstacles, nothing covered.

    Names: ``east_meter_0`` to ``east_meter_2``, ``east_sign_0``, ``east_round``, ``east_board``, ``east_box``, and the
    same of ``north`` and ``west``.
    """
    shell = RoomShell(ROOM)
    rng = np.random.default_rng(_BUILDING_SEED)
    objects: list[SceneObject] = [shell]
    for name in _WALLS:
        objects += _generate_landmarks(name, shell.wall(name)[0], rng)
    return CorridorScene(tuple(objects), _LIGHT)


def covered_walls() -> CorridorScene:
    """Return the walls as they are on the mission: a curtain hangs over the landmarks of the west wall."""
    surface, middle = RoomShell(ROOM).wall('west')[0], _WALLS['west'][0]
    width, height = _CURTAIN
    # It ends at the corner of the room.
    left = min(middle - 0.5 * width, ROOM[4] - width)
    curtain = Occluder('curtain', surface.offset_plane(0.2), (left, 0.35), (width, height), 0.7)
    return bare_walls().with_objects([curtain])


@dataclass(frozen=True)
class FurnishedScene:
    """Walls, and boxes before them, seen from anywhere in the room."""

    walls: CorridorScene
    boxes: tuple[Box, ...] = ()

    def order_for_camera(self, camera_position: NDArray[np.float64]) -> OrderedScene:
        """Return the scene in the order in which it is painted for a camera at a place, shape (3,) [m]."""
        ordered = sort_farthest_first(self.boxes, camera_position)
        objects = [shape for box in ordered for shape in box_shapes(box, self._greys[box])]
        return OrderedScene(_concatenate_tables(self.walls.table, shape_table(objects)), self.walls.light)

    @cached_property
    def _greys(self) -> dict[Box, float]:
        greys = np.random.default_rng(len(self.boxes)).uniform(*_GREYS, len(self.boxes)).tolist()
        return dict(zip(self.boxes, greys, strict=True))


@dataclass(frozen=True)
class OrderedScene:
    """A scene in the order in which it is painted, those behind first, and its light."""

    table: ShapeTable
    light: CorridorLight = field(default_factory=CorridorLight)


def landmarks_on_wall(walls: CorridorScene, name: str) -> tuple[Landmark, ...]:
    """Return the landmarks of the wall of a name."""
    return tuple(landmark for landmark in walls.landmarks if landmark.name.startswith(f'{name}_'))


def _concatenate_tables(first: ShapeTable, second: ShapeTable) -> ShapeTable:
    """Return the shapes of two tables, one after the other."""
    return ShapeTable(
        np.concatenate([first.points, second.points]),
        np.concatenate([first.starts, second.starts[1:] + len(first.points)]),
        np.concatenate([first.surface_of, second.surface_of + len(first.surfaces)]),
        (*first.surfaces, *second.surfaces),
        np.concatenate([first.paints, second.paints]),
    )


def _generate_landmarks(name: str, wall: Surface, rng: np.random.Generator) -> Sequence[SceneObject]:
    """Return the landmarks of a wall: no two gaps, heights or sides are the same on two walls."""
    middle, *texts = _WALLS[name]
    side, radius = float(rng.choice([-1.0, 1.0])), float(rng.uniform(0.09, 0.11))
    gaps = (radius * rng.uniform(2.5, 3.2, 2)).tolist()
    at, height = middle + float(rng.uniform(-0.08, 0.08)), float(rng.uniform(1.45, 1.55))
    places = (at - gaps[0], at, at + gaps[1])
    readings = rng.uniform(0.05, 0.95, 3).tolist()
    meters = [
        Meter(f'{name}_meter_{i}', wall, (place, height), radius, reading)
        for i, (place, reading) in enumerate(zip(places, readings, strict=True))
    ]
    sign = Sign(f'{name}_sign_0', wall, (at + float(rng.uniform(-0.2, 0.2)), 1.82), (0.46, 0.2), (texts[0],))
    low_sign = Sign(f'{name}_sign_1', wall, (middle - side * 0.62, 1.12), (0.3, 0.22), (texts[1],), True)
    board_at = middle + side * float(rng.uniform(0.86, 0.92)), float(rng.uniform(1.4, 1.6))
    board = NoticeBoard(f'{name}_board', wall, board_at, (0.5, 0.4), int(rng.integers(1000)))
    box = Cabinet(f'{name}_box', wall, (middle - 0.2, 1.0), (0.42, 0.28), 0.08, 0.5, 2, 1, 'F 12')
    round_sign = RoundSign(f'{name}_round', wall, (middle - side * 0.7, float(rng.uniform(1.5, 1.65))), 0.11)
    return [*meters, sign, low_sign, board, replace(box, label=f'F {rng.integers(10, 99)}'), round_sign]
