"""The bare walls, floor and ceiling of a rectangular room."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scene_simulator.box_room import Box
from scene_simulator.corridor_drawing import Drawing
from scene_simulator.corridor_landmark import Landmark
from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface

_GREYS = {'south': 0.6, 'west': 0.66, 'north': 0.7, 'east': 0.64}
_DADO = 0.9
"""Height of the darker paint at the bottom of the walls [m]."""
_PANEL = 0.6
"""Width of the ceiling's panels [m]."""


@dataclass(frozen=True)
class RoomShell:
    """A room seen from inside.

    Attributes:
        size: its corners [m].
        name: name of the object in the scene.
    """

    size: Box
    name: str = 'room'

    @property
    def position(self) -> tuple[float, float]:
        """The origin."""
        return 0.0, 0.0

    @property
    def surface(self) -> Surface:
        """The floor, seen from above."""
        x0, y0, z0, *_ = self.size
        return Surface((x0, y0, z0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))

    def wall(self, name: str) -> tuple[Surface, float]:
        """Return a wall, whose origin is its lower left corner as seen from inside, and its length [m].

        Args:
            name: south, west, north or east: at the lowest y, lowest x, highest y or highest x.
        """
        x0, y0, z0, x1, y1, _ = self.size
        origin, right = {
            'south': ((x1, y0, z0), (-1.0, 0.0, 0.0)),
            'west': ((x0, y0, z0), (0.0, 1.0, 0.0)),
            'north': ((x0, y1, z0), (1.0, 0.0, 0.0)),
            'east': ((x1, y1, z0), (0.0, -1.0, 0.0)),
        }[name]
        return Surface(origin, right, (0.0, 0.0, 1.0)), x1 - x0 if right[0] else y1 - y0

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        shapes = [*self._floor(), *self._ceiling()]
        for index, (name, grey) in enumerate(_GREYS.items()):
            surface, length = self.wall(name)
            shapes += self._wall(surface, length, grey, 0.7 * index)
        return shapes

    def landmarks(self) -> list[Landmark]:
        """Return nothing: walls are not taught."""
        return []

    def _wall(self, surface: Surface, length: float, grey: float, shift: float) -> list[FlatShape]:
        drawing, height = Drawing(surface), self.size[5] - self.size[2]
        drawing.rectangle((0.0, 0.0), (length, height), Paint(grey, 0.06, 1.0, (shift, 0.0)))
        drawing.rectangle((0.0, 0.0), (length, _DADO), Paint(0.7 * grey, 0.05, 1.0, (shift, 1.1)))
        drawing.rectangle((0.0, _DADO - 0.02), (length, _DADO + 0.01), Paint(0.4 * grey))
        drawing.rectangle((0.0, 0.0), (length, 0.09), Paint(0.22, 0.04))
        return drawing.shapes

    def _floor(self) -> list[FlatShape]:
        drawing = Drawing(self.surface)
        size = self.size[3] - self.size[0], self.size[4] - self.size[1]
        drawing.rectangle((0.0, 0.0), size, Paint(0.55, 0.07))
        return drawing.shapes

    def _ceiling(self) -> list[FlatShape]:
        x0, y0, _, x1, y1, z1 = self.size
        drawing = Drawing(Surface((x0, y1, z1), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)))
        wide, deep, joint = x1 - x0, y1 - y0, Paint(0.45)
        drawing.rectangle((0.0, 0.0), (wide, deep), Paint(0.6, 0.02))
        for x in np.arange(_PANEL, wide, _PANEL):
            drawing.rectangle((x - 0.006, 0.0), (x + 0.006, deep), joint)
        for y in np.arange(_PANEL, deep, _PANEL):
            drawing.rectangle((0.0, y - 0.006), (wide, y + 0.006), joint)
        return drawing.shapes
