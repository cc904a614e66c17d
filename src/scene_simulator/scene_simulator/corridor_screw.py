"""Screws at the corners of plates."""

from __future__ import annotations

from scene_simulator.corridor_drawing import Drawing, PlanePoint, rectangle_corners
from scene_simulator.corridor_shape import Paint


def draw_screws(drawing: Drawing, low: PlanePoint, high: PlanePoint, radius: float) -> None:
    """Draw a screw with its slot at each corner of a rectangle [m]."""
    for index, (x, y) in enumerate(rectangle_corners(low, high).tolist()):
        drawing.disc((x, y), radius, Paint(0.75))
        reach = 0.75 * radius
        ends = ((x - reach, y), (x + reach, y)) if index % 2 else ((x, y - reach), (x, y + reach))
        drawing.stroke(ends, 0.3 * radius, Paint(0.2))
