"""Pipes and ducts along a wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor_drawing import Drawing, Place
from scene_simulator.corridor_landmark import Landmark
from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface

_STRIPS = 7


@dataclass(frozen=True)
class Pipe:
    """A straight pipe with clamps, drawn flat a little before its wall.

    Attributes:
        name: unique in the corridor.
        surface: the wall.
        place: of the beginning of its middle line [m].
        reach: from there to the other end, right and up [m].
        radius: [m].
        grey: of its paint where it faces the light.
    """

    name: str
    surface: Surface
    place: Place
    reach: tuple[float, float]
    radius: float = 0.04
    grey: float = 0.7

    def shapes(self) -> list[FlatShape]:
        """Return what is painted, the lowest first."""
        wall, pipe = (
            Drawing(self.surface, self.place),
            Drawing(self.surface.raised(1.5 * self.radius), self.place),
        )
        reach, r = np.array(self.reach), self.radius
        length = float(np.hypot(*reach))
        along = reach / length
        across = np.array([-along[1], along[0]])
        shade = np.array([0.4, -0.9]) * r
        wall.stroke(shade + np.outer([0.0, 1.0], reach), 2.0 * r, Paint(0.0, opacity=0.25))
        pipe.stroke(np.outer([0.0, 1.0], reach), 2.0 * r, Paint(0.55 * self.grey))
        for strip in range(1, _STRIPS):
            # Each narrower strip lies on the one before, shifted to the side of the light.
            share = strip / _STRIPS
            offset = 0.35 * share * r * across
            bright = self.grey * (0.55 + 0.5 * share)
            pipe.stroke([offset, reach + offset], 2.0 * r * (1.0 - 0.95 * share) ** 0.6, Paint(bright))
        for at in np.arange(0.35, length, 1.1):
            middle, half = at * along, 1.25 * r * across
            pipe.stroke([middle - half, middle + half], 0.035, Paint(0.3))
        return [*wall.shapes, *pipe.shapes]

    def landmarks(self) -> list[Landmark]:
        """Return nothing: the outline of a pipe is no line on the pipe."""
        return []
