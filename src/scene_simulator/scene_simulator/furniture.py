"""Furniture made of boxes, with the lower left corner at (0, 0)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.box_room import Box

_BOARD = 0.03
"""Thickness of boards and panels [m]."""
_LEG = 0.05
"""Width of a leg [m]."""


@dataclass(frozen=True)
class Furniture:
    """A furniture item.

    Attributes:
        kind: crate, table, rack or overhang.
        boxes: boxes that the item consists of.
    """

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
    legs = (
        (x, y, 0.0, x + _LEG, y + _LEG, height) for x in (0.0, size_x - _LEG) for y in (0.0, size_y - _LEG)
    )
    return Furniture('table', ((0.0, 0.0, height - _BOARD, size_x, size_y, height), *legs))


def rack(size_x: float, size_y: float, height: float, boards: int) -> Furniture:
    """Return an open rack: boards between two panels at the ends of its longer side, nothing behind [m]."""
    if size_x >= size_y:
        panels = (
            (0.0, 0.0, 0.0, _BOARD, size_y, height),
            (size_x - _BOARD, 0.0, 0.0, size_x, size_y, height),
        )
    else:
        panels = (
            (0.0, 0.0, 0.0, size_x, _BOARD, height),
            (0.0, size_y - _BOARD, 0.0, size_x, size_y, height),
        )
    levels = np.linspace(0.1, height - _BOARD, boards).tolist()
    return Furniture('rack', (*panels, *((0.0, 0.0, z, size_x, size_y, z + _BOARD) for z in levels)))


def overhang(size_x: float, size_y: float, low: float, high: float) -> Furniture:
    """Return a cupboard that hangs over free floor [m]."""
    return Furniture('overhang', ((0.0, 0.0, low, size_x, size_y, high),))
