"""Corridor landmarks that can be taught, with their true positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_drawing import PlanePoint, rectangle_corners
from scene_simulator.corridor_surface import Surface


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
        """Return its centre by name, shape (3,), in the map frame [m].

        The centre of the image ellipse is not the image of the circle's centre; see ``circle_image``.
        """
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
        """Return its corners by name/0 to name/3, each of shape (3,), in the map frame [m].

        The order is upper left, upper right, lower right, lower left.
        """
        corners = self.surface.points_map(rectangle_corners(self.low, self.high))
        return {f'{self.name}/{index}': corner for index, corner in enumerate(corners)}


Landmark = RoundLandmark | SquareLandmark
