"""Lights about a room: coded ceiling lamps, plain lamps, windows; the shapes of their faces."""

import math
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.errors import SceneError
from shirube_core.geometry import matrix_from_rpy
from shirube_core.waveform import Waveform, steady_light

_RIM = 96  # points of a round outline
_GRID = 17  # points along a side of a rectangle


class ShapeKind(IntEnum):
    """What the painting kernel makes of a shape's sizes."""

    DISC = 0
    LED_GRID = 1
    RECTANGLE = 2


@dataclass(frozen=True)
class Disc:
    """A round diffuser of a radius [m]."""

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
    """The paper's panel (3.1): 8 x 8 LEDs whose outermost reach ``radius`` from the middle along x and y [m]."""

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
    """A window, a tube or a square panel: extents along the face's x and y [m]."""

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


@dataclass(frozen=True)
class CeilingLamp:
    """A flat luminous face in the map frame and the light it sends.

    A lamp whose waveform has two parts is split along the y axis of its face: the first part is the half with
    negative x, the second the half with positive x.

    Attributes:
        xyz: middle of the face [m].
        shape: outline of the face.
        waveform: what it sends.
        brightness: what the fully lit face collects in a pixel, in full wells per second of exposure [1/s].
        phase: waveform time at time 0 [s].
        clock_offset: how much the lamp's clock is too fast [ppm].
        rpy: fixed-axis roll, pitch, yaw of the face in the map frame [rad]; its x and y axes span the face,
            so ``(0, 0, yaw)`` is a lamp on the ceiling, ``(pi/2, 0, yaw)`` a window in a wall.
    """

    xyz: tuple[float, float, float]
    shape: LampShape = field(default_factory=Disc)
    waveform: Waveform = field(default_factory=steady_light)
    brightness: float = 2000.0
    phase: float = 0.0
    clock_offset: float = 0.0
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse with a SceneError a lamp that cannot hang or shine."""
        if not np.isfinite([*self.xyz, *self.rpy, self.phase, self.clock_offset]).all():
            raise SceneError(f'a lamp at {self.xyz} m has a place, angle, phase or clock that is not finite')
        if not 0.0 <= self.brightness < math.inf:
            raise SceneError(f'a lamp has the brightness {self.brightness}: give 0 or more')

    @cached_property
    def rotation(self) -> NDArray[np.float64]:
        """``R_map_face``, shape (3, 3)."""
        return matrix_from_rpy(self.rpy)

    def mean_levels(self, starts: ArrayLike, stops: ArrayLike) -> NDArray[np.float64]:
        """Return the exact mean levels of the parts over windows of true time [s], shape (..., parts)."""
        return self.waveform.mean_levels(self._lamp_time(starts), self._lamp_time(stops))

    def map_points(self, points_face: ArrayLike) -> NDArray[np.float64]:
        """Take points of the face, shape (n, 2) [m], to the map frame, shape (n, 3) [m]."""
        return np.asarray(np.asarray(points_face, dtype=np.float64) @ self.rotation[:, :2].T + self.xyz)

    def _lamp_time(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return what the lamp's clock shows at true times [s]."""
        return np.asarray(np.asarray(times, dtype=np.float64) * (1.0 + 1e-6 * self.clock_offset) + self.phase)
