"""The paper's room with furniture in it, for a lidar that sees it and a camera that looks past it to the lamps."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from _lamp_room import PLACES, ROOM
from numpy.typing import NDArray

from shirube_core.geometry import SE2

MIDDLE = (0.9, 0.9)  # of the room [m]
BEAMS = 360
RANGE_NOISE = 0.01  # standard deviation of a range [m]
ROBOT_RADIUS = 0.25  # [m]
TRIES = 200
KINDS = (
    *(((1.0, 0.4), 1.8, True),) * 3,
    ((2.0, 0.9), 0.8, True),
    *(((1.4, 0.8), 0.75, False),) * 2,
    *(((0.45, 0.45), 0.9, False),) * 4,
)
"""Shelves, a sofa, sideboards, boxes: width and depth [m], height [m], and whether it is at a wall."""


@dataclass(frozen=True)
class Furniture:
    """A piece of furniture.

    Attributes:
        pose: pose of its centre in the map; at a wall its x axis points into the room.
        size: lengths along its x and y [m].
        height: [m].
    """

    pose: SE2
    size: tuple[float, float]
    height: float

    @property
    def corners(self) -> NDArray[np.float64]:
        """Shape (4, 2), in turn [m]."""
        half = 0.5 * np.array(self.size)
        return self.pose.transform(half * [(-1, -1), (1, -1), (1, 1), (-1, 1)])

    def contains(self, points: NDArray[np.float64], margin: float) -> NDArray[np.bool_]:
        """Return which points, shape (n, 2) [m], are in it or nearer to it than a margin along its axes."""
        inside = np.abs(self.pose.inverse().transform(points)) <= 0.5 * np.array(self.size) + margin
        return np.asarray(inside.all(axis=1))


@dataclass(frozen=True)
class FurnishedRoom:
    """Four walls and furniture."""

    furniture: tuple[Furniture, ...]

    @cached_property
    def _segments(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Starts and ends of walls and sides, shapes (n, 2) [m]."""
        half = 0.5 * np.array(ROOM)
        walls = np.array(MIDDLE) + half * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        outlines = [walls, *(item.corners for item in self.furniture)]
        return np.concatenate(outlines), np.concatenate([np.roll(each, -1, axis=0) for each in outlines])

    def is_free(self, pose: SE2) -> bool:
        """Return whether the robot can stand there."""
        place = np.array([[pose.x, pose.y]])
        in_room = (np.abs(place[0] - MIDDLE) <= 0.5 * np.array(ROOM) - ROBOT_RADIUS).all()
        return bool(in_room) and not any(item.contains(place, ROBOT_RADIUS)[0] for item in self.furniture)

    def scan(self, pose: SE2, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return what the lidar on ``base_link`` sees, shape (BEAMS, 2), points in the base frame [m]."""
        angles = np.arange(BEAMS) * (2.0 * math.pi / BEAMS)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        starts, ends = (pose.inverse().transform(points) for points in self._segments)
        along = ends - starts
        across = directions[:, None, 0] * along[None, :, 1] - directions[:, None, 1] * along[None, :, 0]
        with np.errstate(divide='ignore', invalid='ignore'):
            ranges = (starts[:, 0] * along[:, 1] - starts[:, 1] * along[:, 0]) / across
            share = (starts[None, :, 0] * directions[:, None, 1] - starts[None, :, 1] * directions[:, None, 0]) / across
        hit = (ranges > 0.0) & (share >= 0.0) & (share <= 1.0)
        nearest = np.where(hit, ranges, np.inf).min(axis=1)
        return (nearest + RANGE_NOISE * rng.standard_normal(BEAMS))[:, None] * directions

    def occluded_lamps(self, pose: SE2) -> NDArray[np.bool_]:
        """Return which lamps furniture hides from the camera on the floor, shape (4,)."""
        hidden = np.zeros(len(PLACES), dtype=np.bool_)
        for item in self.furniture:
            # Up to there the way to the lamp is below the top of the piece.
            low = np.linspace(0.0, 1.0, 100)[:, None] * min(item.height / PLACES[0, 2], 1.0)
            for k, lamp in enumerate(PLACES):
                way = np.array([pose.x, pose.y]) + low * (lamp[:2] - [pose.x, pose.y])
                hidden[k] |= item.contains(way, 0.0).any()
        return hidden


def furnished_room(rng: np.random.Generator) -> FurnishedRoom:
    """Return a room with all furniture at places of chance."""
    furniture: list[Furniture] = []
    for size, height, at_wall in KINDS:
        for _ in range(TRIES):
            item = Furniture(_random_furniture(size, rng, at_wall=at_wall), size, height)
            if _is_placeable(item, furniture):
                furniture.append(item)
                break
    return FurnishedRoom(tuple(furniture))


def move_furniture(room: FurnishedRoom, rng: np.random.Generator) -> FurnishedRoom:
    """Return the room with every piece pushed by 5 to 30 cm and turned by up to 10 degrees."""
    furniture = []
    for item in room.furniture:
        way, towards = rng.uniform(0.05, 0.3), rng.uniform(-math.pi, math.pi)
        push = SE2(way * math.cos(towards), way * math.sin(towards), math.radians(rng.uniform(-10.0, 10.0)))
        furniture.append(Furniture(item.pose @ push, item.size, item.height))
    return FurnishedRoom(tuple(furniture))


def _random_furniture(size: tuple[float, float], rng: np.random.Generator, *, at_wall: bool) -> SE2:
    half = 0.5 * np.array(ROOM)
    if not at_wall:
        x, y = MIDDLE + rng.uniform(-1.0, 1.0, 2) * (half - 0.5 * max(size))
        return SE2(float(x), float(y), rng.uniform(-math.pi, math.pi))
    side = int(rng.integers(4))
    along, out = (half[0], half[1]) if side % 2 == 0 else (half[1], half[0])
    local = SE2(rng.uniform(-1.0, 1.0) * (along - 0.5 * size[0]), 0.5 * size[1] - out, 0.0)
    return SE2(*MIDDLE, 0.0) @ SE2(0.0, 0.0, side * 0.5 * math.pi) @ local


def _is_placeable(item: Furniture, others: Sequence[Furniture]) -> bool:
    """Return whether pieces leave room for the robot between them, or touch with no gap to speak of."""
    return not any(other.contains(_grid(item), 0.1).any() or item.contains(_grid(other), 0.1).any() for other in others)


def _grid(item: Furniture) -> NDArray[np.float64]:
    half = 0.5 * np.array(item.size)
    steps = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 7)] * 2), axis=-1).reshape(-1, 2)
    return item.pose.transform(half * steps)
