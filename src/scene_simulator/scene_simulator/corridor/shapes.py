"""Planes, landmarks on them, flat painted shapes, and their light."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]
PlanePoint = tuple[float, float]
_MIDDLE = (0.0, 0.0, 1.3)  # where the light has its level: in the middle of the end wall, in the map frame [m]


@dataclass(frozen=True)
class Surface:
    """A plane seen from its front: origin and unit vectors to the right and up, in the map frame [m]."""

    origin: Vector
    right: Vector
    up: Vector

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit vector towards the viewer, shape (3,)."""
        return np.cross(self.right, self.up)

    def points_map(self, places: ArrayLike) -> NDArray[np.float64]:
        """Take places on the plane, shape (n, 2): right and up, to the map frame, shape (n, 3) [m]."""
        axes = np.array([self.right, self.up])
        return np.asarray(places, dtype=np.float64) @ axes + self.origin

    def offset_plane(self, height: float) -> Surface:
        """Return the parallel plane shifted towards the viewer by a height [m]."""
        x, y, z = (self.origin + height * self.normal).tolist()
        return Surface((x, y, z), self.right, self.up)


def facing_wall(x: float, y: float = 0.0) -> Surface:
    """Return a vertical plane across the corridor at x [m] that faces a viewer looking along the map's x axis."""
    return Surface((x, y, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))


def rectangle_corners(low: PlanePoint, high: PlanePoint) -> NDArray[np.float64]:
    """Return upper left, upper right, lower right and lower left corner, shape (4, 2)."""
    (left, bottom), (right, top) = low, high
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])


@dataclass(frozen=True)
class RoundLandmark:
    """A disc that contrasts with what is around it.

    Attributes:
        name: unique in the corridor.
        surface: plane of the landmark.
        centre: right and up on the plane [m].
        radius: [m].
    """

    name: str
    surface: Surface
    centre: PlanePoint
    radius: float

    @property
    def extent(self) -> tuple[PlanePoint, PlanePoint]:
        """Lower left and upper right corner of the rectangle about it [m]."""
        (x, y), r = self.centre, self.radius
        return (x - r, y - r), (x + r, y + r)

    def points_map(self) -> dict[str, NDArray[np.float64]]:
        """Return its centre by name, shape (3,), in the map frame [m]; not the centre of its elliptic image."""
        return {self.name: self.surface.points_map([self.centre])[0]}


@dataclass(frozen=True)
class SquareLandmark:
    """An upright rectangle that contrasts with what is around it.

    Attributes:
        name: unique in the corridor.
        surface: plane of the landmark.
        low: its lower left corner, right and up on the plane [m].
        high: its upper right corner [m].
    """

    name: str
    surface: Surface
    low: PlanePoint
    high: PlanePoint

    @property
    def extent(self) -> tuple[PlanePoint, PlanePoint]:
        """Its lower left and upper right corner [m]."""
        return self.low, self.high

    def points_map(self) -> dict[str, NDArray[np.float64]]:
        """Return its corners by name/0 (upper left, then clockwise) to name/3, shape (3,), in the map frame [m]."""
        corners = self.surface.points_map(rectangle_corners(self.low, self.high))
        return {f'{self.name}/{index}': corner for index, corner in enumerate(corners)}


Landmark = RoundLandmark | SquareLandmark


@dataclass(frozen=True)
class Paint:
    """How a shape looks.

    Attributes:
        grey: reflectance, 1 is white.
        grain: standard deviation of its texture relative to the grey.
        opacity: 1 hides what is behind.
        shift: offset of the texture along the plane's axes [m]; shapes with different offsets look different.
    """

    grey: float
    grain: float = 0.0
    opacity: float = 1.0
    shift: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, eq=False)
class FlatShape:
    """A filled outline, shape (n, 3), in the map frame [m], its plane and its paint."""

    points: NDArray[np.float64]
    surface: Surface
    paint: Paint


@dataclass(frozen=True, eq=False)
class ShapeTable:
    """Shapes in the order in which they are painted, those behind first.

    Attributes:
        points: shape (n, 3), all outlines one after the other, map frame [m].
        starts: shape (shapes + 1,), where each outline begins.
        surface_of: shape (shapes,), index of each shape's plane.
        surfaces: the planes.
        paints: shape (shapes, 5): grey, grain, opacity, two shifts.
    """

    points: NDArray[np.float64]
    starts: NDArray[np.int64]
    surface_of: NDArray[np.int64]
    surfaces: tuple[Surface, ...]
    paints: NDArray[np.float64]


def shape_table(shapes: Iterable[FlatShape]) -> ShapeTable:
    """Return the table of shapes, in their order."""
    ordered = list(shapes)
    indices: dict[Surface, int] = {}
    surface_of = [indices.setdefault(shape.surface, len(indices)) for shape in ordered]
    paint_rows = [(s.paint.grey, s.paint.grain, s.paint.opacity, *s.paint.shift) for s in ordered]
    return ShapeTable(
        np.concatenate([np.empty((0, 3)), *(shape.points for shape in ordered)]),
        np.cumsum([0, *(len(shape.points) for shape in ordered)], dtype=np.int64),
        np.array(surface_of, dtype=np.int64),
        tuple(indices),
        np.array(paint_rows, dtype=np.float64).reshape(-1, 5),
    )


@dataclass(frozen=True)
class CorridorLight:
    """Level of a white wall before the lens, 1 saturates, and its relative change along the map's axes [1/m]."""

    level: float = 0.95
    gradient: Vector = (0.015, 0.0, 0.09)

    def on_surface(self, surface: Surface) -> tuple[float, float, float]:
        """Return the light at the surface's origin and its slopes to the right and up [1/m]."""
        gradient: NDArray[np.float64] = self.level * np.array(self.gradient)
        at_origin = self.level + float(gradient @ (np.array(surface.origin) - _MIDDLE))
        return at_origin, float(gradient @ surface.right), float(gradient @ surface.up)


class PaintedScene(Protocol):
    """Flat shapes in the order from behind to before, in some light."""

    @property
    def table(self) -> ShapeTable:
        """All shapes."""

    @property
    def light(self) -> CorridorLight:
        """The light on them."""
