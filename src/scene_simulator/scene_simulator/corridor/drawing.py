"""Drawing of flat shapes on a plane: rectangles, discs, strokes, text, screws."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.corridor.shapes import (
    FlatShape,
    Landmark,
    Paint,
    PlanePoint,
    SquareLandmark,
    Surface,
    rectangle_corners,
)

ADVANCE = 0.85  # distance from one letter to the next, the height is 1

# Strokes, separated by blanks, through grid points: 0 to 2 to the right and 0 to 4 up.
_GLYPHS = {
    '0': '0004242000',
    '1': '031410',
    '2': '042422020020',
    '3': '04242000 0222',
    '4': '040222 2420',
    '5': '240402222000',
    '6': '240400202202',
    '7': '042410',
    '8': '0004242000 0222',
    '9': '220204242000',
    'A': '0003142320 0222',
    'B': '0004142312211000 0212',
    'C': '24040020',
    'D': '000414232110 1000',
    'E': '24040020 0212',
    'F': '240400 0212',
    'G': '240400202212',
    'H': '0004 2420 0222',
    'I': '1014',
    'K': '0004 240220',
    'L': '040020',
    'M': '0004122420',
    'N': '00042024',
    'O': '0004242000',
    'P': '0004242202',
    'R': '0004242202 1220',
    'S': '240402222000',
    'T': '0424 1014',
    'U': '04002024',
    'V': '041024',
    'W': '0400122024',
    'X': '0024 0420',
    'Y': '041224 1210',
}
_SAGITTA = 1e-5  # distance of a disc's chords from its circle [m]: at 2 m and f = 700 px less than 0.004 px


def text_strokes(text: str) -> Iterator[NDArray[np.float64]]:
    """Yield the strokes of a line of text, each of shape (n, 2); letters are 1 high and begin at the origin.

    Unknown characters are left blank.
    """
    for index, letter in enumerate(text):
        for stroke in _GLYPHS.get(letter, '').split():
            grid = np.array([int(digit) for digit in stroke], dtype=np.float64).reshape(-1, 2)
            yield grid * (0.3, 0.25) + (index * ADVANCE, 0.0)


class Drawing:
    """Shapes on one plane, bottom first; places count from the drawing's own origin, right and up [m]."""

    def __init__(self, surface: Surface, origin: PlanePoint = (0.0, 0.0)) -> None:
        """Begin an empty drawing about an origin on the plane [m]."""
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


def circle(radius: float) -> NDArray[np.float64]:
    """Return a polygon of the circle's area about the origin, shape (n, 2), fine enough for any picture."""
    count = max(24, math.ceil(math.pi * math.sqrt(0.5 * radius / _SAGITTA)))
    angles = math.tau * np.arange(count) / count
    # The chords cut off area: corners a little outside give it back.
    outside = radius * math.sqrt(math.tau / (count * math.sin(math.tau / count)))
    return outside * np.column_stack([np.cos(angles), np.sin(angles)])


def draw_screws(drawing: Drawing, low: PlanePoint, high: PlanePoint, radius: float) -> None:
    """Draw a screw with its slot at each corner of a rectangle [m]."""
    for index, (x, y) in enumerate(rectangle_corners(low, high).tolist()):
        drawing.disc((x, y), radius, Paint(0.75))
        reach = 0.75 * radius
        ends = ((x - reach, y), (x + reach, y)) if index % 2 else ((x, y - reach), (x, y + reach))
        drawing.stroke(ends, 0.3 * radius, Paint(0.2))


@dataclass(frozen=True)
class WallObject:
    """Something with a unique name on a wall or another plane, at a position right and up on it [m]."""

    name: str
    surface: Surface
    position: PlanePoint

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        return []

    def landmarks(self) -> list[Landmark]:
        """Return what of it can be taught."""
        return []

    def _drawing(self) -> Drawing:
        """Return an empty drawing about the position."""
        return Drawing(self.surface, self.position)

    def _square(self, suffix: str, surface: Surface, low: PlanePoint, high: PlanePoint) -> SquareLandmark:
        """Return a landmark between two corners that count from the position."""
        x, y = self.position
        return SquareLandmark(self.name + suffix, surface, (x + low[0], y + low[1]), (x + high[0], y + high[1]))
