"""Doors of a corridor."""

from __future__ import annotations

from dataclasses import dataclass

from scene_simulator.corridor_drawing import Drawing, PlanePoint
from scene_simulator.corridor_landmark import Landmark, SquareLandmark
from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface


@dataclass(frozen=True)
class Door:
    """A door in a frame, with a window, a handle and a number.

    Attributes:
        name: unique in the corridor.
        surface: the wall.
        position: middle of the sill on the plane, right and up [m].
        size: width and height of the leaf [m].
        grey: reflectance of the leaf, 0 to 1.
        label: number on the leaf.
        handle_left: the handle is on the left.
    """

    name: str
    surface: Surface
    position: PlanePoint
    size: tuple[float, float] = (0.9, 2.05)
    grey: float = 0.38
    label: str = '17'
    handle_left: bool = True

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (width, height) = Drawing(self.surface, self.position), self.size
        half, frame = 0.5 * width, 0.06
        drawing.rectangle((-half - frame, 0.0), (half + frame, height + frame), Paint(0.2))
        drawing.rectangle((-half, 0.01), (half, height), Paint(self.grey, 0.03, 1.0, self.position))
        drawing.rectangle((-0.3 * half, 1.3), (0.3 * half, height - 0.2), Paint(0.12))
        drawing.rectangle((-0.25 * half, 1.32), (0.25 * half, height - 0.22), Paint(0.3, 0.05))
        drawing.rectangle((-0.9 * half, 0.04), (0.9 * half, 0.24), Paint(0.62, 0.03))
        side = -1.0 if self.handle_left else 1.0
        self._handle(drawing, side * (half - 0.08), side)
        drawing.rectangle((-0.14, 1.08), (0.14, 1.2), Paint(0.9))
        drawing.text(self.label, (0.0, 1.14), 0.08, Paint(0.1))
        for hinge in (0.25, 1.05, height - 0.25):
            drawing.rectangle(
                (-side * half - 0.012, hinge - 0.06), (-side * half + 0.012, hinge + 0.06), Paint(0.55)
            )
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the leaf and its window."""
        (x, y), (width, height) = self.position, self.size
        half = 0.5 * width
        leaf = SquareLandmark(self.name, self.surface, (x - half, y + 0.01), (x + half, y + height))
        low, high = (x - 0.25 * half, y + 1.32), (x + 0.25 * half, y + height - 0.22)
        return [leaf, SquareLandmark(f'{self.name}/window', self.surface, low, high)]

    def _handle(self, drawing: Drawing, x: float, side: float) -> None:
        drawing.rectangle((x - 0.022, 0.93), (x + 0.022, 1.13), Paint(0.8))
        drawing.disc((x, 1.06), 0.017, Paint(0.3))
        drawing.stroke([(x, 1.06), (x - side * 0.12, 1.06)], 0.02, Paint(0.15))
        drawing.disc((x, 0.97), 0.008, Paint(0.1))
