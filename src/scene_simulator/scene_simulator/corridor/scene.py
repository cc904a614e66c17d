"""A corridor: objects in back-to-front order, people and boards before them, and the true landmark positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor.drawing import WallObject
from scene_simulator.corridor.shapes import CorridorLight, FlatShape, Landmark, Paint, ShapeTable, Surface, shape_table
from scene_simulator.errors import SceneError


@dataclass(frozen=True)
class Person(WallObject):
    """A person in the corridor, cut out of an upright plane.

    Attributes:
        position: point between the feet on the plane, right and up [m].
        height: [m].
        greys: reflectances of jacket, trousers and helmet, 0 to 1.
    """

    height: float = 1.75
    greys: tuple[float, float, float] = (0.35, 0.2, 0.8)

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, h = self._drawing(), self.height
        jacket, trousers, helmet = self.greys
        for side in (-1.0, 1.0):
            leg = [(0.01, 0.5), (0.095, 0.5), (0.075, 0.03), (0.025, 0.03)]
            drawing.polygon(h * np.array(leg) * (side, 1.0), Paint(trousers, 0.06))
            left, right = sorted((side * 0.02 * h, side * 0.1 * h))
            drawing.rectangle((left, 0.0), (right, 0.035 * h), Paint(0.08))
            arm = [(0.115, 0.81), (0.155, 0.76), (0.165, 0.47), (0.125, 0.47), (0.11, 0.7)]
            drawing.polygon(h * np.array(arm) * (side, 1.0), Paint(0.85 * jacket, 0.06))
            drawing.disc((side * 0.145 * h, 0.455 * h), 0.024 * h, Paint(0.6))
        half = [(-0.1, 0.46), (-0.095, 0.7), (-0.125, 0.81), (-0.03, 0.845)]
        torso = [*half, *((-x, y) for x, y in reversed(half))]
        drawing.polygon(h * np.array(torso), Paint(jacket, 0.06))
        drawing.stroke([(0.0, 0.47 * h), (0.0, 0.83 * h)], 0.006, Paint(0.5 * jacket))
        for band in (0.56, 0.68):
            drawing.rectangle((-0.098 * h, band * h), (0.098 * h, (band + 0.025) * h), Paint(0.9))
        drawing.rectangle((-0.025 * h, 0.83 * h), (0.025 * h, 0.88 * h), Paint(0.55))
        drawing.disc((0.0, 0.915 * h), 0.058 * h, Paint(0.62))
        angles = np.linspace(0.0, np.pi, 24)
        dome = np.column_stack([0.066 * np.cos(angles), 0.935 + 0.065 * np.sin(angles)])
        drawing.polygon(h * dome, Paint(helmet))
        drawing.rectangle((-0.078 * h, 0.93 * h), (0.078 * h, 0.94 * h), Paint(0.8 * helmet))
        return drawing.shapes


@dataclass(frozen=True)
class Occluder(WallObject):
    """A plain board that hides what is behind it.

    Attributes:
        position: lower left corner on the plane, right and up [m].
        size: width and height [m].
        grey: reflectance of the paint, 0 to 1.
    """

    size: tuple[float, float]
    grey: float = 0.5

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""
        drawing, (width, height) = self._drawing(), self.size
        drawing.rectangle((0.0, 0.0), self.size, Paint(self.grey, 0.08, 1.0, self.position))
        drawing.stroke([(0.0, 0.5 * height), (width, 0.5 * height)], 0.01, Paint(0.7 * self.grey))
        return drawing.shapes


class SceneObject(Protocol):
    """Something in a corridor; a frozen dataclass."""

    @property
    def name(self) -> str:
        """Unique in the corridor."""

    @property
    def surface(self) -> Surface:
        """The plane to which it belongs."""

    @property
    def position(self) -> tuple[float, float]:
        """Where it is on the plane, right and up [m]."""

    def shapes(self) -> list[FlatShape]:
        """Return the painted shapes, bottom first."""

    def landmarks(self) -> list[Landmark]:
        """Return what of it can be taught."""


@dataclass(frozen=True)
class CorridorScene:
    """The scene.

    Attributes:
        objects: objects, farthest first.
        light: illumination of all objects.
    """

    objects: tuple[SceneObject, ...]
    light: CorridorLight = field(default_factory=CorridorLight)

    @cached_property
    def table(self) -> ShapeTable:
        """All shapes, for the renderer."""
        return shape_table(shape for item in self.objects for shape in item.shapes())

    @cached_property
    def landmarks(self) -> tuple[Landmark, ...]:
        """What can be taught."""
        return tuple(landmark for item in self.objects for landmark in item.landmarks())

    def points_map(self) -> dict[str, NDArray[np.float64]]:
        """Return every point that can be taught by name, each of shape (3,), in the map frame [m]."""
        return {name: point for landmark in self.landmarks for name, point in landmark.points_map().items()}

    def item(self, name: str) -> SceneObject:
        """Return the thing of a name, or raise SceneError."""
        named = {item.name: item for item in reversed(self.objects)}
        if name not in named:
            there = ', '.join(item.name for item in self.objects)
            raise SceneError(f'there is no {name!r} in the corridor; it has {there}')
        return named[name]

    def move_object(self, name: str, right: float, up: float) -> CorridorScene:
        """Return the corridor with the thing of a name moved on its plane [m], or raise SceneError."""
        old = self.item(name)
        new = replace(cast(Any, old), position=(old.position[0] + right, old.position[1] + up))
        return replace(self, objects=tuple(new if item is old else item for item in self.objects))

    def with_objects(self, objects: Sequence[SceneObject]) -> CorridorScene:
        """Return the corridor with objects in front of all others, farthest first."""
        return replace(self, objects=(*self.objects, *objects))

    def cover_landmark(self, name: str) -> CorridorScene:
        """Return the corridor with a paper cover over the landmark of a name, or raise SceneError."""
        named = {landmark.name: landmark for landmark in reversed(self.landmarks)}
        if name not in named:
            raise SceneError(f'there is no landmark {name!r}; there are {", ".join(x.name for x in self.landmarks)}')
        (left, low), (right, high) = named[name].extent
        surface = named[name].surface.offset_plane(0.01)
        size = right - left + 0.06, high - low + 0.06
        return self.with_objects([Occluder(f'{name}_cover', surface, (left - 0.03, low - 0.03), size, 0.8)])
