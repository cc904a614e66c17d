"""Rooms with crates, tables, shelves and overhangs at places that a seed decides, with a way left free."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.box_room import Box, BoxRoom
from scene_simulator.furniture import Furniture, crate, overhang, shelf, table
from scene_simulator.scene_error import SceneError

_GAP = 0.1
"""Between the footprints of two pieces [m]."""
_TRIES = 2000


@dataclass(frozen=True)
class FurnishedRoom:
    """A room and what stands in it.

    Attributes:
        size: the room's own corners.
        furniture: piece by piece.
    """

    size: Box
    furniture: tuple[Furniture, ...]

    @property
    def boxes(self) -> BoxRoom:
        """The same as boxes, to be looked at."""
        return BoxRoom(self.size, tuple(box for piece in self.furniture for box in piece.boxes))


@dataclass(frozen=True)
class Furnishing:
    """How many pieces of each kind a room has; shelves and overhangs are at its walls."""

    crates: int = 5
    tables: int = 2
    shelves: int = 2
    overhangs: int = 2


def furnish(
    size: Box, furnishing: Furnishing, seed: int, way_map: ArrayLike, keep_free: float
) -> FurnishedRoom:
    """Furnish a room.

    Args:
        size: the room's own corners [m].
        furnishing: number of pieces.
        seed: decides sizes and places.
        way_map: array-like, shape (n, 2), points of a way that stays free [m]; n may be 0.
        keep_free: distance of all pieces from these points [m].

    Raises:
        SceneError: there is no place for a piece, or a negative seed.
    """
    if seed < 0:
        raise SceneError(f'the seed is {seed}: give 0 or a positive number')
    rng = np.random.default_rng(seed)
    way = np.asarray(way_map, dtype=np.float64).reshape(-1, 2)
    placed: list[Furniture] = []
    for count, make, is_at_wall in (
        (furnishing.shelves, _any_shelf, True),
        (furnishing.overhangs, _any_overhang, True),
        (furnishing.tables, _any_table, False),
        (furnishing.crates, _any_crate, False),
    ):
        for _ in range(count):
            placed.append(_place(size, make, is_at_wall, placed, (way, keep_free), rng))
    return FurnishedRoom(size, tuple(placed))


def _place(
    size: Box,
    make: Callable[[np.random.Generator], Furniture],
    is_at_wall: bool,
    others: list[Furniture],
    free: tuple[NDArray[np.float64], float],
    rng: np.random.Generator,
) -> Furniture:
    """Return a new piece at the first place tried at which it hinders nobody."""
    way, keep_free = free
    for _ in range(_TRIES):
        piece = make(rng)
        low, room = np.array(size[:2]), np.array(size[3:5]) - size[:2] - piece.footprint[2:]
        share = rng.random(2)
        if is_at_wall:
            # The longer side lies along the wall.
            across = int(piece.footprint[2] > piece.footprint[3])
            share[across] = round(share[across])
        x, y = (low + share * room).tolist()
        piece = piece.moved(x, y)
        is_clear = bool((piece.distances_to(way) >= keep_free).all())
        if (room > 0.0).all() and is_clear and not any(_touch(piece, other) for other in others):
            return piece
    raise SceneError('there is no place for another piece of furniture; give a larger room or fewer pieces')


def _touch(one: Furniture, other: Furniture) -> bool:
    a, b = np.array(one.footprint), np.array(other.footprint)
    return bool((a[:2] < b[2:] + _GAP).all() and (b[:2] < a[2:] + _GAP).all())


def _any_crate(rng: np.random.Generator) -> Furniture:
    return crate(*_between(rng, (0.25, 0.25, 0.3), (0.6, 0.6, 1.0)))


def _any_table(rng: np.random.Generator) -> Furniture:
    return table(*_between(rng, (0.7, 0.6, 0.65), (1.2, 0.8, 0.78)))


def _any_shelf(rng: np.random.Generator) -> Furniture:
    length, depth, height = _between(rng, (0.8, 0.3, 1.4), (1.4, 0.45, 1.9))
    return shelf(*((length, depth) if rng.random() < 0.5 else (depth, length)), height, 4)


def _any_overhang(rng: np.random.Generator) -> Furniture:
    length, depth, low = _between(rng, (0.8, 0.35, 0.6), (1.4, 0.5, 0.8))
    return overhang(*((length, depth) if rng.random() < 0.5 else (depth, length)), low, low + 0.7)


def _between(
    rng: np.random.Generator, low: tuple[float, float, float], high: tuple[float, float, float]
) -> tuple[float, float, float]:
    x, y, z = rng.uniform(low, high).tolist()
    return x, y, z
