"""Random rooms with crates, tables, racks and overhangs, all made of boxes, and a free path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.errors import SceneError
from scene_simulator.room.box_room import Box, BoxRoom

_BOARD = 0.03  # thickness of boards and panels [m]
_LEG = 0.05  # width of a leg [m]
_GAP = 0.1  # minimum gap between two footprints [m]
_TRIES = 2000


@dataclass(frozen=True)
class Furniture:
    """A crate, table, rack or overhang, and the boxes that it consists of."""

    kind: str
    boxes: tuple[Box, ...]

    @property
    def footprint(self) -> tuple[float, float, float, float]:
        """Lowest x and y, highest x and y [m]."""
        corners = np.array(self.boxes)
        (x0, y0), (x1, y1) = corners[:, :2].min(axis=0).tolist(), corners[:, 3:5].max(axis=0).tolist()
        return x0, y0, x1, y1

    def translate(self, x: float, y: float) -> Furniture:
        """Return the item translated along x and y [m]."""
        boxes = ((a + x, b + y, c, d + x, e + y, f) for a, b, c, d, e, f in self.boxes)
        return Furniture(self.kind, tuple(boxes))

    def distances_to(self, points_map: ArrayLike) -> NDArray[np.float64]:
        """Return how far points, shape (n, 2), are from the footprint, shape (n,); 0 over it [m]."""
        points = np.asarray(points_map, dtype=np.float64)
        x0, y0, x1, y1 = self.footprint
        return np.asarray(np.hypot(*(np.clip(points, (x0, y0), (x1, y1)) - points).T))


def crate(size_x: float, size_y: float, height: float) -> Furniture:
    """Return a closed box on the floor [m]."""
    return Furniture('crate', ((0.0, 0.0, 0.0, size_x, size_y, height),))


def table(size_x: float, size_y: float, height: float) -> Furniture:
    """Return a table top on four legs [m]."""
    legs = ((x, y, 0.0, x + _LEG, y + _LEG, height) for x in (0.0, size_x - _LEG) for y in (0.0, size_y - _LEG))
    return Furniture('table', ((0.0, 0.0, height - _BOARD, size_x, size_y, height), *legs))


def rack(size_x: float, size_y: float, height: float, boards: int) -> Furniture:
    """Return an open rack: boards between two panels at the ends of its longer side, nothing behind [m]."""
    if size_x >= size_y:
        panels = ((0.0, 0.0, 0.0, _BOARD, size_y, height), (size_x - _BOARD, 0.0, 0.0, size_x, size_y, height))
    else:
        panels = ((0.0, 0.0, 0.0, size_x, _BOARD, height), (0.0, size_y - _BOARD, 0.0, size_x, size_y, height))
    levels = np.linspace(0.1, height - _BOARD, boards).tolist()
    return Furniture('rack', (*panels, *((0.0, 0.0, z, size_x, size_y, z + _BOARD) for z in levels)))


def overhang(size_x: float, size_y: float, low: float, high: float) -> Furniture:
    """Return a cupboard that hangs over free floor [m]."""
    return Furniture('overhang', ((0.0, 0.0, low, size_x, size_y, high),))


@dataclass(frozen=True)
class FurnishedRoom:
    """A room, by its own corners, and its furniture."""

    size: Box
    furniture: tuple[Furniture, ...]

    @property
    def boxes(self) -> BoxRoom:
        """The same as boxes, to be looked at."""
        return BoxRoom(self.size, tuple(box for item in self.furniture for box in item.boxes))


@dataclass(frozen=True)
class Furnishing:
    """Number of furniture items of each kind; racks and overhangs are at the walls."""

    crates: int = 5
    tables: int = 2
    racks: int = 2
    overhangs: int = 2


def furnish(size: Box, furnishing: Furnishing, seed: int, path_map: ArrayLike, clearance: float) -> FurnishedRoom:
    """Furnish a room.

    Args:
        size: the room's own corners [m].
        furnishing: number of items of each kind.
        seed: seed of sizes and positions.
        path_map: array-like, shape (n, 2), points of a path that stays free [m]; n may be 0.
        clearance: minimum distance of all furniture from these points [m].

    Raises:
        SceneError: no free position for an item, or a negative seed.
    """
    if seed < 0:
        raise SceneError(f'the seed is {seed}: give 0 or a positive number')
    rng = np.random.default_rng(seed)
    path = np.asarray(path_map, dtype=np.float64).reshape(-1, 2)
    placed: list[Furniture] = []
    for count, make, is_at_wall in (
        (furnishing.racks, _random_rack, True),
        (furnishing.overhangs, _random_overhang, True),
        (furnishing.tables, _random_table, False),
        (furnishing.crates, _random_crate, False),
    ):
        for _ in range(count):
            placed.append(_place_furniture(size, make, is_at_wall, placed, (path, clearance), rng))
    return FurnishedRoom(size, tuple(placed))


def _place_furniture(
    size: Box,
    make: Callable[[np.random.Generator], Furniture],
    is_at_wall: bool,
    others: list[Furniture],
    free: tuple[NDArray[np.float64], float],
    rng: np.random.Generator,
) -> Furniture:
    """Return a new item at the first random position without a collision."""
    path, clearance = free
    for _ in range(_TRIES):
        item = make(rng)
        low, room = np.array(size[:2]), np.array(size[3:5]) - size[:2] - item.footprint[2:]
        fraction = rng.random(2)
        if is_at_wall:
            # The longer side is along the wall.
            across = int(item.footprint[2] > item.footprint[3])
            fraction[across] = round(fraction[across])
        x, y = (low + fraction * room).tolist()
        item = item.translate(x, y)
        is_clear = bool((item.distances_to(path) >= clearance).all())
        if (room > 0.0).all() and is_clear and not any(_is_overlapping(item, other) for other in others):
            return item
    raise SceneError('no free position for another item of furniture; use a larger room or fewer items')


def _is_overlapping(one: Furniture, other: Furniture) -> bool:
    a, b = np.array(one.footprint), np.array(other.footprint)
    return bool((a[:2] < b[2:] + _GAP).all() and (b[:2] < a[2:] + _GAP).all())


def _random_crate(rng: np.random.Generator) -> Furniture:
    return crate(*_random_size(rng, (0.25, 0.25, 0.3), (0.6, 0.6, 1.0)))


def _random_table(rng: np.random.Generator) -> Furniture:
    return table(*_random_size(rng, (0.7, 0.6, 0.65), (1.2, 0.8, 0.78)))


def _random_rack(rng: np.random.Generator) -> Furniture:
    length, depth, height = _random_size(rng, (0.8, 0.3, 1.4), (1.4, 0.45, 1.9))
    return rack(*((length, depth) if rng.random() < 0.5 else (depth, length)), height, 4)


def _random_overhang(rng: np.random.Generator) -> Furniture:
    length, depth, low = _random_size(rng, (0.8, 0.35, 0.6), (1.4, 0.5, 0.8))
    return overhang(*((length, depth) if rng.random() < 0.5 else (depth, length)), low, low + 0.7)


def _random_size(
    rng: np.random.Generator, low: tuple[float, float, float], high: tuple[float, float, float]
) -> tuple[float, float, float]:
    x, y, z = rng.uniform(low, high).tolist()
    return x, y, z
