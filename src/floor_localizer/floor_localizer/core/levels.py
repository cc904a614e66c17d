"""Levels of one map: the floors of a building side by side in one map frame, so that one index covers them all."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from floor_localizer.core.errors import FloorLocalizerError
from shirube_core.geometry import SE2

# Gap between levels, larger than any constellation [m].
_GAP = 2.0
# Largest extent of the map; single precision resolves 0.03 mm there [m].
_MAX_EXTENT = 1024.0


@dataclass(frozen=True)
class Level:
    """One level (floor) of the map.

    Attributes:
        name: name of the level.
        offset: x and y of the level's origin in the map frame [m].
        lower: lower left corner of its dots in the map frame [m].
        upper: upper right corner [m].
    """

    name: str
    offset: tuple[float, float]
    lower: tuple[float, float]
    upper: tuple[float, float]

    def to_map(self, T_level_base: SE2) -> SE2:
        """Transform a pose from the level frame to the map frame."""
        return SE2(T_level_base.x + self.offset[0], T_level_base.y + self.offset[1], T_level_base.yaw)

    def to_level(self, T_map_base: SE2) -> SE2:
        """Transform a pose from the map frame to the level frame; the inverse of `to_map`."""
        return SE2(T_map_base.x - self.offset[0], T_map_base.y - self.offset[1], T_map_base.yaw)


def arrange_levels(
    names: Sequence[str], corners: Sequence[tuple[float, float, float, float]]
) -> tuple[Level, ...]:
    """Arrange levels side by side in rows that form about a square.

    ``corners`` are the bounding box (x min, y min, x max, y max) of the dots of each level in its own frame [m].

    Raises:
        FloorLocalizerError: the levels together are larger than single precision allows.
    """
    columns = math.ceil(math.sqrt(len(names)))
    width = math.ceil(max(x1 - x0 for x0, _, x1, _ in corners) + _GAP)
    height = math.ceil(max(y1 - y0 for _, y0, _, y1 in corners) + _GAP)
    if len(names) > 1 and max(width * columns, height * math.ceil(len(names) / columns)) > _MAX_EXTENT:
        raise FloorLocalizerError(
            f'{len(names)} levels of up to {width} x {height} m are too large for one map of {_MAX_EXTENT:.0f} m; '
            'make several maps'
        )
    levels = []
    for number, (name, (x0, y0, x1, y1)) in enumerate(zip(names, corners, strict=True)):
        row, column = divmod(number, columns)
        # Whole metres, to keep the rounding to single precision small.
        dx, dy = float(column * width - math.floor(x0)), float(row * height - math.floor(y0))
        levels.append(Level(name, (dx, dy), (x0 + dx, y0 + dy), (x1 + dx, y1 + dy)))
    return tuple(levels)


def level_at(levels: Sequence[Level], x: float, y: float) -> Level | None:
    """Return the level nearest to a point of the map [m], None for a map without levels."""
    return min(levels, key=lambda level: _distance(level, x, y), default=None)


def _distance(level: Level, x: float, y: float) -> float:
    dx = max(level.lower[0] - x, 0.0, x - level.upper[0])
    dy = max(level.lower[1] - y, 0.0, y - level.upper[1])
    return math.hypot(dx, dy)
