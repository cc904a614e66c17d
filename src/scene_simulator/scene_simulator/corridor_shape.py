"""Flat shapes in space, each of one paint, and a table of many for the renderer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_surface import Surface


@dataclass(frozen=True)
class Paint:
    """How a shape looks.

    Attributes:
        grey: reflectance, 1 is white.
        grain: standard deviation of its texture relative to the grey.
        opacity: 1 hides what is behind.
        shift: offset of the texture along the plane's axes [m]; shapes with different offsets look different.
    """

    grey: float
    grain: float = 0.0
    opacity: float = 1.0
    shift: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class FlatShape:
    """A filled outline.

    Attributes:
        points: shape (n, 3), the outline in the map frame [m].
        surface: plane of the shape.
        paint: its look.
    """

    points: NDArray[np.float64]
    surface: Surface
    paint: Paint


@dataclass(frozen=True, eq=False)
class ShapeTable:
    """Shapes in the order in which they are painted, those behind first.

    Attributes:
        points: shape (n, 3), all outlines one after the other, map frame [m].
        starts: shape (shapes + 1,), where each outline begins.
        surface_of: shape (shapes,), index of each shape's plane.
        surfaces: the planes.
        paints: shape (shapes, 5): grey, grain, opacity, two shifts.
    """

    points: NDArray[np.float64]
    starts: NDArray[np.int64]
    surface_of: NDArray[np.int64]
    surfaces: tuple[Surface, ...]
    paints: NDArray[np.float64]


def shape_table(shapes: Iterable[FlatShape]) -> ShapeTable:
    """Return the table of shapes, in their order."""
    ordered = list(shapes)
    indices: dict[Surface, int] = {}
    surface_of = [indices.setdefault(shape.surface, len(indices)) for shape in ordered]
    paint_rows = [(s.paint.grey, s.paint.grain, s.paint.opacity, *s.paint.shift) for s in ordered]
    return ShapeTable(
        np.concatenate([np.empty((0, 3)), *(shape.points for shape in ordered)]),
        np.cumsum([0, *(len(shape.points) for shape in ordered)], dtype=np.int64),
        np.array(surface_of, dtype=np.int64),
        tuple(indices),
        np.array(paint_rows, dtype=np.float64).reshape(-1, 5),
    )
