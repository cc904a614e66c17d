"""Outlines of luminous faces. Coordinates are in the face's own plane, origin in its middle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

_RIM = 96
"""Points of a round outline."""

_GRID = 17
"""Points along a side of a rectangle."""


class ShapeKind(IntEnum):
    """What the painting kernel makes of a shape's sizes."""

    DISC = 0
    LED_GRID = 1
    RECTANGLE = 2


@dataclass(frozen=True)
class Disc:
    """A round diffuser.

    Attributes:
        radius: [m].
    """

    radius: float = 0.0325

    kind = ShapeKind.DISC

    @property
    def sizes(self) -> tuple[float, float, float]:
        """What the kernel needs: the radius [m]."""
        return self.radius, 0.0, 0.0

    def outline(self) -> NDArray[np.float64]:
        """Return the outline counter-clockwise, shape (n, 2) [m]."""
        return self.radius * _unit_circle()

    def bounding_points(self) -> NDArray[np.float64]:
        """Return points whose hull holds the shape, shape (n, 2) [m]."""
        return self.outline()


@dataclass(frozen=True)
class LedGrid:
    """The paper's panel (3.1): 8 x 8 LEDs, whose outermost reach ``radius`` from the middle along x and y.

    Attributes:
        radius: half the panel's width [m].
        led_radius: radius of one LED [m].
        count: LEDs along a side.
    """

    radius: float = 0.0325
    led_radius: float = 0.0025
    count: int = 8

    kind = ShapeKind.LED_GRID

    @property
    def pitch(self) -> float:
        """Distance of neighbouring LEDs [m]."""
        return 2.0 * (self.radius - self.led_radius) / (self.count - 1)

    @property
    def sizes(self) -> tuple[float, float, float]:
        """What the kernel needs: an LED's radius [m], their pitch [m] and number along a side."""
        return self.led_radius, self.pitch, float(self.count)

    def outline(self) -> NDArray[np.float64]:
        """Return the square about all LEDs counter-clockwise, shape (n, 2) [m]."""
        return Rectangle(2.0 * self.radius, 2.0 * self.radius).outline()

    def bounding_points(self) -> NDArray[np.float64]:
        """Return points whose hull holds the shape, shape (n, 2) [m]."""
        return self.outline()


@dataclass(frozen=True)
class Rectangle:
    """A window, a tube or a square panel.

    Attributes:
        width: extent along the face's x [m].
        length: extent along the face's y [m].
    """

    width: float
    length: float

    kind = ShapeKind.RECTANGLE

    @property
    def sizes(self) -> tuple[float, float, float]:
        """What the kernel needs: half the width and half the length [m]."""
        return 0.5 * self.width, 0.5 * self.length, 0.0

    def outline(self) -> NDArray[np.float64]:
        """Return the outline counter-clockwise, with points along the sides, shape (n, 2) [m]."""
        side = np.linspace(-1.0, 1.0, _GRID)[:-1]
        one = np.ones_like(side)
        corners = [(side, -one), (one, side), (-side, one), (-one, -side)]
        return np.concatenate([np.column_stack(xy) for xy in corners]) * self.sizes[:2]

    def bounding_points(self) -> NDArray[np.float64]:
        """Return points all over the shape, because a large one may be in view without its outline."""
        side = np.linspace(-1.0, 1.0, _GRID)
        return np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2) * self.sizes[:2]


LampShape = Disc | LedGrid | Rectangle


def _unit_circle() -> NDArray[np.float64]:
    angles = np.arange(_RIM) * (math.tau / _RIM)
    return np.column_stack([np.cos(angles), np.sin(angles)])
