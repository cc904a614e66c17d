"""Round meters with a needle, and switch cabinets with windows, lamps and switches on their front."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor.drawing import Drawing, WallObject, draw_screws
from scene_simulator.corridor.shapes import FlatShape, Landmark, Paint, PlanePoint, RoundLandmark, Surface

_SWEEP = math.radians(270.0)
_FACE = 0.85  # radius of the white face, relative to the meter's
_FRAME = 0.022  # width of an instrument's frame [m]


@dataclass(frozen=True)
class Meter(WallObject):
    """A meter on a wall; meters of one size differ only in the needle.

    Attributes:
        position: centre on the plane, right and up [m].
        radius: radius of the rim [m].
        reading: needle position, 0 to 1.
        case: 'round', 'square', or 'lined': round between the two lines of its bracket (the paper's figure 4).
    """

    radius: float = 0.1
    reading: float = 0.3
    case: str = 'round'

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, r = self._drawing(), self.radius
        frame, face = Paint(0.13, 0.02), Paint(0.93, 0.01)
        if self.case == 'square':
            drawing.rectangle((-r, -r), (r, r), frame)
            drawing.rectangle((-_FACE * r, -_FACE * r), (_FACE * r, _FACE * r), face)
        else:
            if self.case == 'lined':
                drawing.rectangle((-0.25 * r, -2.2 * r), (0.25 * r, -0.9 * r), frame)
            drawing.disc((0.0, 0.0), r, frame)
            drawing.disc((0.0, 0.0), _FACE * r, face)
        self._scale(drawing)
        self._needle(drawing)
        return drawing.shapes

    def landmarks(self) -> list[Landmark]:
        """Return the rim."""
        if self.case == 'square':
            r = self.radius
            return [self._square('', self.surface, (-r, -r), (r, r))]
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


@dataclass(frozen=True)
class Cabinet(WallObject):
    """A box on a wall.

    Attributes:
        position: lower left corner on the plane, right and up [m].
        size: width and height [m].
        depth: distance of the front from the wall [m].
        grey: reflectance of the paint, 0 to 1.
        columns: number of columns of fields on the front.
        rows: number of rows of fields; fields alternate: windows, name plates, lamps with switches.
        label: label on the upper edge.
    """

    size: tuple[float, float] = (0.9, 0.7)
    depth: float = 0.12
    grey: float = 0.45
    columns: int = 3
    rows: int = 2
    label: str = 'MCC 1'

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        wall = self._drawing()
        wall.shadow((0.0, 0.0), self.size, 0.5 * self.depth)
        front, (width, height) = Drawing(self._front, self.position), self.size
        front.rectangle((0.0, 0.0), self.size, Paint(self.grey, 0.015, 1.0, self.position))
        draw_screws(front, (0.025, 0.025), (width - 0.025, height - 0.025), 0.009)
        front.text(self.label, (0.5 * width, height - 0.05), 0.045, Paint(0.93))
        for index, (low, high) in enumerate(self._fields()):
            (_draw_window, _draw_lamps, _draw_plate)[(index + index // self.columns) % 3](front, low, high)
        return [*wall.shapes, *self._sides(), *front.shapes]

    def landmarks(self) -> list[Landmark]:
        """Return the front and its fields."""
        front = self._square('', self._front, (0.0, 0.0), self.size)
        fields = enumerate(self._fields())
        return [front, *(self._square(f'/field_{i}', self._front, *corners) for i, corners in fields)]

    @property
    def _front(self) -> Surface:
        return self.surface.offset_plane(self.depth)

    def _fields(self) -> list[tuple[PlanePoint, PlanePoint]]:
        """Return the lower left and upper right corner of each field on the front [m]."""
        (width, height), margin = self.size, 0.06
        pitch = (width - margin) / self.columns, (height - 0.1 - margin) / self.rows
        places = [(column, row) for row in range(self.rows) for column in range(self.columns)]
        lows = [(margin + column * pitch[0], margin + row * pitch[1]) for column, row in places]
        return [((x, y), (x + pitch[0] - margin, y + pitch[1] - margin)) for x, y in lows]

    def _sides(self) -> list[FlatShape]:
        """Return the four sides, each reaching under the front, so that no seam shows the wall between them."""
        (x, y), (width, height) = self.position, self.size
        corners = np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])
        back, front = self.surface.points_map(corners), self._front.points_map(corners)
        middle = front.mean(axis=0)
        sides = []
        for index, shade in enumerate((0.35, 0.6, 1.15, 0.7)):
            after = (index + 1) % 4
            outline = np.array([back[index], back[after], front[after], middle, front[index]])
            surface = _side_surface(back[index], back[after], self.surface.normal)
            sides.append(FlatShape(outline, surface, Paint(shade * self.grey)))
        return sides


def _side_surface(start: NDArray[np.float64], stop: NDArray[np.float64], out: NDArray[np.float64]) -> Surface:
    """Return the plane through an edge on the wall, perpendicular to the wall."""
    x, y, z = start.tolist()
    right = (stop - start) / np.linalg.norm(stop - start)
    return Surface((x, y, z), (right[0], right[1], right[2]), (out[0], out[1], out[2]))


def _draw_window(drawing: Drawing, low: PlanePoint, high: PlanePoint) -> None:
    """Draw an instrument with a dark frame and a scale."""
    drawing.rectangle(low, high, Paint(0.1))
    inner_low, inner_high = (low[0] + _FRAME, low[1] + _FRAME), (high[0] - _FRAME, high[1] - _FRAME)
    drawing.rectangle(inner_low, inner_high, Paint(0.85))
    width, height = inner_high[0] - inner_low[0], inner_high[1] - inner_low[1]
    for index, fraction in enumerate(np.linspace(0.1, 0.9, 11)):
        x, top = inner_low[0] + fraction * width, 0.75 if index % 5 else 0.85
        ends = [(x, inner_low[1] + 0.55 * height), (x, inner_low[1] + top * height)]
        drawing.stroke(ends, 0.004, Paint(0.1))
    middle = (0.5 * (low[0] + high[0]), inner_low[1] + 0.25 * height)
    drawing.text('KV', middle, 0.2 * height, Paint(0.15))


def _draw_lamps(drawing: Drawing, low: PlanePoint, high: PlanePoint) -> None:
    """Draw two lamps over two switches on a plate."""
    drawing.rectangle(low, high, Paint(0.78))
    width, height = high[0] - low[0], high[1] - low[1]
    radius = 0.11 * min(width, height)
    for fraction, grey in ((0.3, 0.25), (0.7, 0.95)):
        lamp = (low[0] + fraction * width, low[1] + 0.7 * height)
        drawing.disc(lamp, 1.35 * radius, Paint(0.2))
        drawing.disc(lamp, radius, Paint(grey))
        switch = (low[0] + fraction * width, low[1] + 0.3 * height)
        drawing.disc(switch, 1.5 * radius, Paint(0.12))
        (x, y), wide, tall = switch, 0.3 * radius, 1.3 * radius
        drawing.rectangle((x - wide, y - tall), (x + wide, y + tall), Paint(0.4))


def _draw_plate(drawing: Drawing, low: PlanePoint, high: PlanePoint) -> None:
    """Draw a name plate with three lines."""
    drawing.rectangle(low, high, Paint(0.92))
    height = high[1] - low[1]
    for fraction, text in ((0.75, 'PUMP'), (0.5, '400 V'), (0.25, 'KEEP OUT')):
        position = (0.5 * (low[0] + high[0]), low[1] + fraction * height)
        drawing.text(text, position, min(0.13 * height, 0.11 * (high[0] - low[0])), Paint(0.12))
