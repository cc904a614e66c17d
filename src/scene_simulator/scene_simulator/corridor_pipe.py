"""Pipes and ducts along a wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor_drawing import Drawing, PlanePoint
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
        position: start of the centre line on the plane, right and up [m].
        extent: vector from the start to the end, right and up [m].
        radius: [m].
        grey: reflectance of the paint on the lit side, 0 to 1.
    """

    name: str
    surface: Surface
    position: PlanePoint
    extent: tuple[float, float]
    radius: float = 0.04
    grey: float = 0.7

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        wall, pipe = (
            Drawing(self.surface, self.position),
            Drawing(self.surface.offset_plane(1.5 * self.radius), self.position),
        )
        extent, r = np.array(self.extent), self.radius
        length = float(np.hypot(*extent))
        along = extent / length
        across = np.array([-along[1], along[0]])
        shade = np.array([0.4, -0.9]) * r
        wall.stroke(shade + np.outer([0.0, 1.0], extent), 2.0 * r, Paint(0.0, opacity=0.25))
        pipe.stroke(np.outer([0.0, 1.0], extent), 2.0 * r, Paint(0.55 * self.grey))
        for strip in range(1, _STRIPS):
            # Each narrower strip overlays the previous one, shifted towards the light.
            fraction = strip / _STRIPS
            offset = 0.35 * fraction * r * across
            bright = self.grey * (0.55 + 0.5 * fraction)
            pipe.stroke([offset, extent + offset], 2.0 * r * (1.0 - 0.95 * fraction) ** 0.6, Paint(bright))
        for at in np.arange(0.35, length, 1.1):
            middle, half = at * along, 1.25 * r * across
            pipe.stroke([middle - half, middle + half], 0.035, Paint(0.3))
        return [*wall.shapes, *pipe.shapes]

    def landmarks(self) -> list[Landmark]:
        """Return nothing: the occluding contour of a pipe is not a fixed line on it."""
        return []
