"""Lights about a room: coded ceiling lamps, plain lamps, windows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scene_simulator.errors import SceneError
from scene_simulator.lamp_shape import Disc, LampShape
from shirube_core.geometry import matrix_from_rpy
from shirube_core.waveform import Waveform, steady_light


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
        """Refuse a lamp that cannot hang or shine.

        Raises:
            SceneError: a place or angle that is not finite, or a brightness below zero or not finite.
        """
        if not np.isfinite([*self.xyz, *self.rpy, self.phase, self.clock_offset]).all():
            raise SceneError(f'a lamp at {self.xyz} m has a place, angle, phase or clock that is not finite')
        if not 0.0 <= self.brightness < math.inf:
            raise SceneError(f'a lamp has the brightness {self.brightness}: give 0 or more')

    @cached_property
    def rotation(self) -> NDArray[np.float64]:
        """``R_map_face``, shape (3, 3)."""
        return matrix_from_rpy(self.rpy)

    def mean_levels(self, starts: ArrayLike, stops: ArrayLike) -> NDArray[np.float64]:
        """Return the exact mean levels of the parts over windows of true time, shape (..., parts).

        Args:
            starts: array-like, any shape [s].
            stops: array-like, same shape [s].
        """
        return self.waveform.mean_levels(self._lamp_time(starts), self._lamp_time(stops))

    def map_points(self, points_face: ArrayLike) -> NDArray[np.float64]:
        """Take points of the face, shape (n, 2) [m], to the map frame, shape (n, 3) [m]."""
        return np.asarray(np.asarray(points_face, dtype=np.float64) @ self.rotation[:, :2].T + self.xyz)

    def _lamp_time(self, times: ArrayLike) -> NDArray[np.float64]:
        """Return what the lamp's clock shows at true times [s]."""
        return np.asarray(np.asarray(times, dtype=np.float64) * (1.0 + 1e-6 * self.clock_offset) + self.phase)
