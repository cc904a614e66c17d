"""A round meter with a needle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_drawing import Drawing
from scene_simulator.corridor_landmark import Landmark, RoundLandmark
from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface

_SWEEP = math.radians(270.0)
_FACE = 0.85
"""Radius of the white face, relative to the meter's."""


@dataclass(frozen=True)
class Meter:
    """A meter on a wall; meters of one size differ only in the needle.

    Attributes:
        name: unique in the corridor.
        surface: the wall.
        position: centre on the plane, right and up [m].
        radius: radius of the rim [m].
        reading: needle position, 0 to 1.
    """

    name: str
    surface: Surface
    position: tuple[float, float]
    radius: float = 0.1
    reading: float = 0.3

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, r = Drawing(self.surface, self.position), self.radius
        drawing.disc((0.0, 0.0), r, Paint(0.13, 0.02))
        drawing.disc((0.0, 0.0), _FACE * r, Paint(0.93, 0.01))
        self._scale(drawing)
        self._needle(drawing)
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the rim."""
        return [RoundLandmark(self.name, self.surface, self.position, self.radius)]

    def _scale(self, drawing: Drawing) -> None:
        """Draw ticks, a red zone at the end and the unit."""
        r, black = self.radius, Paint(0.08)
        angles = _angle(np.linspace(0.8, 1.0, 9))
        zone = np.column_stack([np.cos(angles), np.sin(angles)])
        drawing.polygon(r * np.concatenate([0.7 * zone, 0.78 * zone[::-1]]), Paint(0.35))
        for index, angle in enumerate(_angle(np.linspace(0.0, 1.0, 31))):
            inner, width = (0.64, 0.028) if index % 5 == 0 else (0.71, 0.014)
            ray = np.array([math.cos(angle), math.sin(angle)])
            drawing.stroke([inner * r * ray, 0.79 * r * ray], width * r, black)
        drawing.text('MPA', (0.0, -0.42 * r), 0.15 * r, black)

    def _needle(self, drawing: Drawing) -> None:
        r, angle = self.radius, float(_angle(np.array(self.reading)))
        ray = np.array([math.cos(angle), math.sin(angle)])
        across = np.array([-ray[1], ray[0]])
        outline = [-0.2 * ray - 0.035 * across, 0.72 * ray, -0.2 * ray + 0.035 * across]
        drawing.polygon(r * np.array(outline), Paint(0.05))
        drawing.disc((0.0, 0.0), 0.085 * r, Paint(0.2))


def _angle(reading: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the direction of readings, 0 to 1, counter-clockwise from the right [rad]."""
    return np.asarray(0.5 * math.pi + _SWEEP * (0.5 - reading))
