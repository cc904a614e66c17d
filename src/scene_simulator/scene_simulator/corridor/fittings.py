"""Signs, notice boards, doors and pipes on a wall."""

from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor.drawing import Drawing, WallObject, draw_screws
from scene_simulator.corridor.shapes import FlatShape, Landmark, Paint, PlanePoint, RoundLandmark

_STRIPS = 7


@dataclass(frozen=True)
class Sign(WallObject):
    """A plate with lines of text.

    Attributes:
        position: centre on the plane, right and up [m].
        size: width and height [m].
        lines: lines of text.
        inverted: white on dark.
    """

    size: tuple[float, float] = (0.4, 0.2)
    lines: tuple[str, ...] = ('EXIT',)
    inverted: bool = False

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (low, high) = self._drawing(), self._corners
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
        return [self._square('', self.surface, *self._corners)]

    @property
    def _corners(self) -> tuple[PlanePoint, PlanePoint]:
        width, height = self.size
        return (-0.5 * width, -0.5 * height), (0.5 * width, 0.5 * height)


@dataclass(frozen=True)
class RoundSign(WallObject):
    """A round prohibition sign of a radius [m]; its position is its centre on the plane, right and up [m]."""

    radius: float = 0.11

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, r = self._drawing(), self.radius
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
class NoticeBoard(WallObject):
    """A cork board of a width and height [m] about its position, with papers at random."""

    size: tuple[float, float] = (0.8, 0.6)
    seed: int = 0

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (width, height) = self._drawing(), self.size
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
        width, height = self.size
        return [self._square('', self.surface, (-0.5 * width, -0.5 * height), (0.5 * width, 0.5 * height))]

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


@dataclass(frozen=True)
class Door(WallObject):
    """A door in a frame, with a window, a handle and a number.

    Attributes:
        position: middle of the sill on the plane, right and up [m].
        size: width and height of the leaf [m].
        grey: reflectance of the leaf, 0 to 1.
        label: number on the leaf.
        handle_left: the handle is on the left.
    """

    size: tuple[float, float] = (0.9, 2.05)
    grey: float = 0.38
    label: str = '17'
    handle_left: bool = True

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (width, height) = self._drawing(), self.size
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
            drawing.rectangle((-side * half - 0.012, hinge - 0.06), (-side * half + 0.012, hinge + 0.06), Paint(0.55))
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the leaf and its window."""
        half, height = 0.5 * self.size[0], self.size[1]
        low, high = (-0.25 * half, 1.32), (0.25 * half, height - 0.22)
        leaf = self._square('', self.surface, (-half, 0.01), (half, height))
        return [leaf, self._square('/window', self.surface, low, high)]

    def _handle(self, drawing: Drawing, x: float, side: float) -> None:
        drawing.rectangle((x - 0.022, 0.93), (x + 0.022, 1.13), Paint(0.8))
        drawing.disc((x, 1.06), 0.017, Paint(0.3))
        drawing.stroke([(x, 1.06), (x - side * 0.12, 1.06)], 0.02, Paint(0.15))
        drawing.disc((x, 0.97), 0.008, Paint(0.1))


@dataclass(frozen=True)
class Pipe(WallObject):
    """A straight pipe with clamps, drawn flat a little before its wall; its outline is no fixed line to teach.

    Attributes:
        position: start of the centre line on the plane, right and up [m].
        extent: vector from the start to the end, right and up [m].
        radius: [m].
        grey: reflectance of the paint on the lit side, 0 to 1.
    """

    extent: tuple[float, float]
    radius: float = 0.04
    grey: float = 0.7

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        wall, pipe = self._drawing(), Drawing(self.surface.offset_plane(1.5 * self.radius), self.position)
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
