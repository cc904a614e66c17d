"""The bare walls, floor and ceiling of a corridor, and of a rectangular room."""

from dataclasses import dataclass

import numpy as np

from scene_simulator.corridor.drawing import Drawing
from scene_simulator.corridor.shapes import FlatShape, Landmark, Paint, Surface, facing_wall
from scene_simulator.room.box_room import Box

LENGTH = 12.0  # length of the corridor from the end wall at x = 0 [m]
_BEYOND = 0.5  # how far floor, ceiling and side walls go on behind the walls that end them, so that no seam is seen [m]
_JOINT = 0.005  # joint width between tiles [m]
_PLASTER, _DADO, _GROUND = 0.06, 0.05, 0.07  # standard deviations of the textures
_GREYS = {'south': 0.6, 'west': 0.66, 'north': 0.7, 'east': 0.64}
_DADO_HEIGHT = 0.9  # height of the darker paint at the bottom of the walls [m]
_PANEL = 0.6  # width of the ceiling's panels [m]


@dataclass(frozen=True)
class CorridorShell:
    """Walls, floor and ceiling.

    The end wall is the map's plane x = 0; its vertical centre line passes through the map's origin.

    Attributes:
        width: corridor width [m].
        height: ceiling height [m].
        dado: height of the darker paint at the bottom of the walls [m]; 0 is none.
        shift: offset of the textures [m].
        tile: width of the walls' tiles [m]; 0 is plaster.
        name: name of the object in the scene.
    """

    width: float = 4.4
    height: float = 2.8
    dado: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    tile: float = 0.0
    name: str = 'shell'

    @property
    def position(self) -> tuple[float, float]:
        """The origin."""
        return 0.0, 0.0

    @property
    def surface(self) -> Surface:
        """The end wall."""
        return facing_wall(0.0)

    @property
    def left_wall(self) -> Surface:
        """The left wall when facing the end wall; its right axis points towards the end wall."""
        return Surface((0.0, 0.5 * self.width, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))

    @property
    def right_wall(self) -> Surface:
        """The right wall; its right axis points away from the end wall."""
        return Surface((0.0, -0.5 * self.width, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        half = 0.5 * self.width
        walls = (
            (self.left_wall, -LENGTH, _BEYOND, 0.56),
            (self.right_wall, -_BEYOND, LENGTH, 0.6),
            (self.surface, -half, half, 0.68),
        )
        shapes = [*self._ground(), *self._ceiling()]
        for surface, low, high, grey in walls:
            shapes += self._wall(surface, low, high, grey)
        return shapes

    def landmarks(self) -> list[Landmark]:
        """Return nothing: walls are not taught."""
        return []

    def _wall(self, surface: Surface, low: float, high: float, grey: float) -> list[FlatShape]:
        drawing = Drawing(surface)
        drawing.rectangle((low, 0.0), (high, self.height), Paint(grey, _PLASTER, 1.0, self.shift))
        if self.dado > 0.0:
            shift = (self.shift[0] + 1.1, self.shift[1] + 0.7)
            drawing.rectangle((low, 0.0), (high, self.dado), Paint(0.62 * grey, _DADO, 1.0, shift))
            drawing.rectangle((low, self.dado - 0.02), (high, self.dado + 0.01), Paint(0.35 * grey))
        if self.tile > 0.0:
            self._joints(drawing, low, high, Paint(0.6 * grey))
        drawing.rectangle((low, 0.0), (high, 0.09), Paint(0.22, 0.04))
        return drawing.shapes

    def _joints(self, drawing: Drawing, low: float, high: float, paint: Paint) -> None:
        """Draw the joints between tiles."""
        for x in np.arange(low, high, self.tile):
            drawing.rectangle((x - 0.5 * _JOINT, 0.0), (x + 0.5 * _JOINT, self.height), paint)
        for y in np.arange(self.tile, self.height, self.tile):
            drawing.rectangle((low, y - 0.5 * _JOINT), (high, y + 0.5 * _JOINT), paint)

    def _ground(self) -> list[FlatShape]:
        """Return the floor, with tiles and a painted edge on both sides."""
        drawing = Drawing(Surface((0.0, 0.0, 0.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)))
        side, joint = 0.5 * self.width + _BEYOND, Paint(0.27)
        drawing.rectangle((-side, -LENGTH), (side, _BEYOND), Paint(0.4, _GROUND, 1.0, self.shift))
        for x in np.arange(-LENGTH, _BEYOND, 0.6):
            drawing.rectangle((-side, x - 0.004), (side, x + 0.004), joint)
        for y in np.arange(-side, side, 0.6):
            drawing.rectangle((y - 0.004, -LENGTH), (y + 0.004, _BEYOND), joint)
        for edge in (-0.5 * self.width + 0.25, 0.5 * self.width - 0.25):
            drawing.rectangle((edge - 0.04, -LENGTH), (edge + 0.04, -0.3), Paint(0.75, 0.08))
        return drawing.shapes

    def _ceiling(self) -> list[FlatShape]:
        """Return the ceiling, with panels and two rows of lamps."""
        drawing = Drawing(Surface((0.0, 0.0, self.height), (0.0, -1.0, 0.0), (-1.0, 0.0, 0.0)))
        side = 0.5 * self.width + _BEYOND
        drawing.rectangle((-side, -_BEYOND), (side, LENGTH), Paint(0.6, 0.02, 1.0, self.shift))
        for x in np.arange(0.3, LENGTH, 0.6):
            drawing.rectangle((-side, x - 0.006), (side, x + 0.006), Paint(0.42))
        for x in np.arange(0.9, LENGTH, 2.4):
            for y in (-0.9, 0.9):
                drawing.rectangle((y - 0.16, x), (y + 0.16, x + 1.2), Paint(0.45))
                drawing.rectangle((y - 0.13, x + 0.03), (y + 0.13, x + 1.17), Paint(1.6))
        return drawing.shapes


@dataclass(frozen=True)
class RoomShell:
    """A room, seen from inside, with its corners [m] and its name in the scene."""

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
        drawing.rectangle((0.0, 0.0), (length, _DADO_HEIGHT), Paint(0.7 * grey, 0.05, 1.0, (shift, 1.1)))
        drawing.rectangle((0.0, _DADO_HEIGHT - 0.02), (length, _DADO_HEIGHT + 0.01), Paint(0.4 * grey))
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
