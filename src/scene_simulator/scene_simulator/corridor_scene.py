"""A corridor: objects in back-to-front order, their illumination, and the true landmark positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_landmark import Landmark
from scene_simulator.corridor_light import CorridorLight
from scene_simulator.corridor_occluder import Occluder
from scene_simulator.corridor_shape import FlatShape, ShapeTable, shape_table
from scene_simulator.corridor_surface import Surface
from scene_simulator.errors import SceneError


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
        """Return the thing of a name.

        Raises:
            SceneError: there is none.
        """
        found = [item for item in self.objects if item.name == name]
        if not found:
            raise SceneError(
                f'there is no {name!r} in the corridor; it has {", ".join(item.name for item in self.objects)}'
            )
        return found[0]

    def move_object(self, name: str, right: float, up: float) -> CorridorScene:
        """Return the corridor with one thing moved on its plane [m].

        Raises:
            SceneError: there is no thing of the name.
        """
        old = self.item(name)
        new = replace(cast(Any, old), position=(old.position[0] + right, old.position[1] + up))
        return replace(self, objects=tuple(new if item is old else item for item in self.objects))

    def with_objects(self, objects: Sequence[SceneObject]) -> CorridorScene:
        """Return the corridor with objects in front of all others, farthest first."""
        return replace(self, objects=(*self.objects, *objects))

    def cover_landmark(self, name: str) -> CorridorScene:
        """Return the corridor with a paper cover over a landmark.

        Raises:
            SceneError: there is no landmark of the name.
        """
        found = [landmark for landmark in self.landmarks if landmark.name == name]
        if not found:
            raise SceneError(
                f'there is no landmark {name!r}; there are {", ".join(x.name for x in self.landmarks)}'
            )
        low, high = found[0].extent
        position, size = (low[0] - 0.03, low[1] - 0.03), (high[0] - low[0] + 0.06, high[1] - low[1] + 0.06)
        return self.with_objects(
            [Occluder(f'{name}_cover', found[0].surface.offset_plane(0.01), position, size, 0.8)]
        )
