"""A corridor: things in the order from behind to before, their light, and where everything truly is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_figure import Occluder
from scene_simulator.corridor_landmark import Landmark
from scene_simulator.corridor_light import CorridorLight
from scene_simulator.corridor_shape import FlatShape, ShapeTable, shape_table
from scene_simulator.corridor_surface import Surface
from scene_simulator.scene_error import SceneError


class Thing(Protocol):
    """Something in a corridor; a frozen dataclass."""

    @property
    def name(self) -> str:
        """Unique in the corridor."""

    @property
    def surface(self) -> Surface:
        """The plane to which it belongs."""

    @property
    def place(self) -> tuple[float, float]:
        """Where it is on the plane, right and up [m]."""

    def shapes(self) -> list[FlatShape]:
        """Return what is painted, the lowest first."""

    def landmarks(self) -> list[Landmark]:
        """Return what of it can be taught."""


@dataclass(frozen=True)
class CorridorScene:
    """What there is to see.

    Attributes:
        things: those behind first.
        light: on all of them.
    """

    things: tuple[Thing, ...]
    light: CorridorLight = field(default_factory=CorridorLight)

    @cached_property
    def table(self) -> ShapeTable:
        """All shapes, for the renderer."""
        return shape_table(shape for thing in self.things for shape in thing.shapes())

    @cached_property
    def landmarks(self) -> tuple[Landmark, ...]:
        """What can be taught."""
        return tuple(landmark for thing in self.things for landmark in thing.landmarks())

    def points_map(self) -> dict[str, NDArray[np.float64]]:
        """Return every point that can be taught by name, each of shape (3,), in the map frame [m]."""
        return {name: point for landmark in self.landmarks for name, point in landmark.points_map().items()}

    def thing(self, name: str) -> Thing:
        """Return the thing of a name.

        Raises:
            SceneError: there is none.
        """
        found = [thing for thing in self.things if thing.name == name]
        if not found:
            raise SceneError(
                f'there is no {name!r} in the corridor; it has {", ".join(thing.name for thing in self.things)}'
            )
        return found[0]

    def moved(self, name: str, right: float, up: float) -> CorridorScene:
        """Return the corridor with one thing moved on its plane [m].

        Raises:
            SceneError: there is no thing of the name.
        """
        old = self.thing(name)
        new = replace(cast(Any, old), place=(old.place[0] + right, old.place[1] + up))
        return replace(self, things=tuple(new if thing is old else thing for thing in self.things))

    def with_things(self, things: Sequence[Thing]) -> CorridorScene:
        """Return the corridor with things before all others, those behind first."""
        return replace(self, things=(*self.things, *things))

    def covered(self, name: str) -> CorridorScene:
        """Return the corridor with a sheet of paper over a landmark.

        Raises:
            SceneError: there is no landmark of the name.
        """
        found = [landmark for landmark in self.landmarks if landmark.name == name]
        if not found:
            raise SceneError(
                f'there is no landmark {name!r}; there are {", ".join(x.name for x in self.landmarks)}'
            )
        low, high = found[0].extent
        place, size = (low[0] - 0.03, low[1] - 0.03), (high[0] - low[0] + 0.06, high[1] - low[1] + 0.06)
        return self.with_things([Occluder(f'{name}_cover', found[0].surface.raised(0.01), place, size, 0.8)])
