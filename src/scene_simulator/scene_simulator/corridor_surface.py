"""Planes of a corridor on which things are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Surface:
    """A plane with axes to the right and up, seen from its front.

    Attributes:
        origin: where the axes begin, in the map frame [m].
        right: unit vector in the map frame.
        up: unit vector in the map frame, at a right angle to it.
    """

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
    """Return a vertical plane across the corridor that faces a viewer looking along the map's x axis.

    Args:
        x: x of the plane [m].
        y: y of the origin, which is on the floor [m].
    """
    return Surface((x, y, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
