"""Boxes as flat shapes, for cameras that see painted scenes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from scene_simulator.box_room import Box
from scene_simulator.corridor_drawing import Drawing
from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface

_GRAIN = 0.08
_EDGE = 0.012
"""Width of the worn edges of a box [m]."""
_TOP, _SIDES = 1.15, (0.8, 0.95)
"""Brightness of the top, and of the sides across x and y, relative to the paint."""


def box_shapes(box: Box, grey: float) -> list[FlatShape]:
    """Return the top and the four sides of a box; whoever paints them leaves out those that are turned away.

    Args:
        box: its corners [m].
        grey: reflectance of the paint, 0 to 1.
    """
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
    """Return boxes in the order in which they are painted, by the distance of their nearest points.

    Args:
        boxes: that do not overlap.
        camera_position: shape (3,), camera position in the map frame [m].
    """

    def distance(box: Box) -> float:
        corners = np.array(box)
        return float(np.linalg.norm(np.clip(camera_position, corners[:3], corners[3:]) - camera_position))

    return sorted(boxes, key=distance, reverse=True)
