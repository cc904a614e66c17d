"""Signs and boards on a wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor_drawing import Drawing, PlanePoint
from scene_simulator.corridor_landmark import Landmark, RoundLandmark, SquareLandmark
from scene_simulator.corridor_screw import draw_screws
from scene_simulator.corridor_shape import FlatShape, Paint
from scene_simulator.corridor_surface import Surface


@dataclass(frozen=True)
class Sign:
    """A plate with lines of text.

    Attributes:
        name: unique in the corridor.
        surface: the wall.
        position: centre on the plane, right and up [m].
        size: width and height [m].
        lines: lines of text.
        inverted: white on dark.
    """

    name: str
    surface: Surface
    position: PlanePoint
    size: tuple[float, float] = (0.4, 0.2)
    lines: tuple[str, ...] = ('EXIT',)
    inverted: bool = False

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (low, high) = Drawing(self.surface, self.position), self._corners
        paper, ink = (Paint(0.15), Paint(0.9)) if self.inverted else (Paint(0.9, 0.01), Paint(0.1))
        drawing.rectangle(low, high, paper)
        draw_screws(drawing, (low[0] + 0.014, low[1] + 0.014), (high[0] - 0.014, high[1] - 0.014), 0.006)
        pitch = 0.8 * self.size[1] / max(1, len(self.lines))
        widest = max(map(len, self.lines), default=1)
        letter = min(0.62 * pitch, 0.85 * self.size[0] / (0.85 * widest + 0.2))
        for index, line in enumerate(self.lines):
            drawing.text(line, (0.0, 0.4 * self.size[1] - (index + 0.5) * pitch), letter, ink)
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the plate."""
        (x, y), (low, high) = self.position, self._corners
        return [SquareLandmark(self.name, self.surface, (x + low[0], y + low[1]), (x + high[0], y + high[1]))]

    @property
    def _corners(self) -> tuple[PlanePoint, PlanePoint]:
        width, height = self.size
        return (-0.5 * width, -0.5 * height), (0.5 * width, 0.5 * height)


@dataclass(frozen=True)
class RoundSign:
    """A round prohibition sign.

    Attributes:
        name: unique in the corridor.
        surface: the wall.
        position: centre on the plane, right and up [m].
        radius: [m].
    """

    name: str
    surface: Surface
    position: PlanePoint
    radius: float = 0.11

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, r = Drawing(self.surface, self.position), self.radius
        drawing.disc((0.0, 0.0), r, Paint(0.25))
        drawing.disc((0.0, 0.0), 0.8 * r, Paint(0.92))
        drawing.disc((0.0, 0.3 * r), 0.14 * r, Paint(0.08))
        drawing.stroke([(0.0, 0.14 * r), (0.0, -0.5 * r)], 0.22 * r, Paint(0.08))
        drawing.stroke([(-0.6 * r, 0.6 * r), (0.6 * r, -0.6 * r)], 0.16 * r, Paint(0.25))
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the rim."""
        return [RoundLandmark(self.name, self.surface, self.position, self.radius)]


@dataclass(frozen=True)
class NoticeBoard:
    """A cork board with papers at random.

    Attributes:
        name: unique in the corridor.
        surface: the wall.
        position: centre on the plane, right and up [m].
        size: width and height [m].
        seed: seed of the papers.
    """

    name: str
    surface: Surface
    position: PlanePoint
    size: tuple[float, float] = (0.8, 0.6)
    seed: int = 0

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (width, height) = Drawing(self.surface, self.position), self.size
        low, high = (-0.5 * width, -0.5 * height), (0.5 * width, 0.5 * height)
        drawing.shadow(low, high, 0.02)
        drawing.rectangle(low, high, Paint(0.75))
        drawing.rectangle((low[0] + 0.02, low[1] + 0.02), (high[0] - 0.02, high[1] - 0.02), Paint(0.4, 0.1))
        rng = np.random.default_rng(self.seed)
        for column in range(3):
            self._paper(drawing, (low[0] + (column + 0.5) * width / 3.0, 0.0), rng)
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the frame."""
        (x, y), (width, height) = self.position, self.size
        low, high = (x - 0.5 * width, y - 0.5 * height), (x + 0.5 * width, y + 0.5 * height)
        return [SquareLandmark(self.name, self.surface, low, high)]

    def _paper(self, drawing: Drawing, middle: PlanePoint, rng: np.random.Generator) -> None:
        """Draw a slightly rotated page with lines of writing."""
        half = np.array([0.105, 0.148]) * rng.uniform(0.6, 0.95) * self.size[0] / 0.8
        turn = rng.uniform(-0.06, 0.06)
        axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        centre = np.array(middle) + rng.uniform(-1.0, 1.0, 2) * (0.01, 0.2 * self.size[1] - 0.04)
        corners = np.array([(-1, 1), (1, 1), (1, -1), (-1, -1)]) * half
        drawing.polygon(centre + corners @ axes, Paint(float(rng.uniform(0.8, 0.95))))
        for fraction in np.linspace(0.75, -0.75, 9):
            ends = np.array([(-0.8, fraction), (rng.uniform(0.1, 0.8), fraction)]) * half
            drawing.stroke(centre + ends @ axes, 0.006, Paint(0.35))
        drawing.disc((centre[0], centre[1] + 0.9 * half[1]), 0.008, Paint(0.15))
