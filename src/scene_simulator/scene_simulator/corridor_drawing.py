"""Drawing of flat shapes on a plane: rectangles, discs, strokes, text."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface
from scene_simulator.stroke_font import ADVANCE, text_strokes

PlanePoint = tuple[float, float]

_SAGITTA = 1e-5
"""Distance of a disc's chords from its circle [m]: at 2 m and f = 700 px less than 0.004 px."""


class Drawing:
    """Shapes on one plane; places count from the drawing's own origin, right and up [m].

    Attributes:
        shapes: drawn shapes, bottom first.
    """

    def __init__(self, surface: Surface, origin: PlanePoint = (0.0, 0.0)) -> None:
        """Begin an empty drawing.

        Args:
            surface: the plane.
            origin: origin of the drawing on the plane [m].
        """
        self.surface, self.origin = surface, origin
        self.shapes: list[FlatShape] = []

    def polygon(self, outline: ArrayLike, paint: Paint) -> None:
        """Draw a polygon, shape (n, 2)."""
        places = np.asarray(outline, dtype=np.float64) + self.origin
        self.shapes.append(FlatShape(self.surface.points_map(places), self.surface, paint))

    def rectangle(self, low: PlanePoint, high: PlanePoint, paint: Paint) -> None:
        """Draw an upright rectangle between its lower left and its upper right corner."""
        self.polygon(rectangle_corners(low, high), paint)

    def disc(self, centre: PlanePoint, radius: float, paint: Paint) -> None:
        """Draw a disc."""
        self.polygon(np.array(centre) + circle(radius), paint)

    def stroke(self, points: ArrayLike, width: float, paint: Paint) -> None:
        """Draw straight segments of a width between points, shape (n, 2), with square ends."""
        places = np.asarray(points, dtype=np.float64)
        for start, stop in pairwise(places):
            along = 0.5 * width * (stop - start) / math.hypot(*(stop - start))
            across = np.array([-along[1], along[0]])
            ends = [start - along - across, stop + along - across, stop + along + across]
            self.polygon([*ends, start - along + across], paint)

    def text(self, text: str, position: PlanePoint, height: float, paint: Paint) -> None:
        """Write a line of capital letters and digits; the place is the middle of the line."""
        width = ADVANCE * (len(text) - 1) + 0.6
        left, bottom = position[0] - 0.5 * width * height, position[1] - 0.5 * height
        for stroke in text_strokes(text):
            self.stroke((left, bottom) + height * stroke, 0.16 * height, paint)

    def shadow(self, low: PlanePoint, high: PlanePoint, depth: float = 0.02) -> None:
        """Draw the shadow of an object that protrudes from the plane by ``depth`` [m]."""
        for fraction in (1.0, 0.66, 0.33):
            reach = fraction * depth
            shift = 0.3 * reach, -reach
            corners = ((low[0] + shift[0], low[1] + shift[1]), (high[0] + shift[0], high[1] + shift[1]))
            self.rectangle(*corners, Paint(0.0, opacity=0.13))


def rectangle_corners(low: PlanePoint, high: PlanePoint) -> NDArray[np.float64]:
    """Return upper left, upper right, lower right and lower left corner, shape (4, 2)."""
    (left, bottom), (right, top) = low, high
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])


def circle(radius: float) -> NDArray[np.float64]:
    """Return a polygon of the circle's area about the origin, shape (n, 2), fine enough for any picture."""
    count = max(24, math.ceil(math.pi * math.sqrt(0.5 * radius / _SAGITTA)))
    angles = math.tau * np.arange(count) / count
    # The chords cut off area: corners a little outside give it back.
    outside = radius * math.sqrt(math.tau / (count * math.sin(math.tau / count)))
    return outside * np.column_stack([np.cos(angles), np.sin(angles)])
