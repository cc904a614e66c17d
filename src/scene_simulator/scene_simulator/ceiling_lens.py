"""Lens model: vignetting, defocus, blooming and lens flare."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from scene_simulator.blooming import Blooming
from shirube_core.geometry import PinholeCamera

_FLARE_EDGE_SLOPE = 1.0
"""Edge slope of a flare [1/px]."""


@dataclass(frozen=True)
class LensFlare:
    """Lens flare: a faint reflected image of every lamp, at ``scale`` times its offset from the principal point.

    Attributes:
        scale: position relative to the principal point; negative is on the opposite side.
        strength: brightness relative to the lamp.
        radius: radius of the flare spot [px].
    """

    scale: float = -0.55
    strength: float = 0.04
    radius: float = 9.0

    @property
    def margin(self) -> float:
        """Distance from the centre beyond which a flare is not visible [px]."""
        return self.radius + 12.0 / _FLARE_EDGE_SLOPE

    def profile(self, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the brightness relative to the lamp at distances from the flare's centre [px]."""
        edge = 0.5 * _FLARE_EDGE_SLOPE * (distances - self.radius)
        return np.asarray(self.strength * (0.5 - 0.5 * np.tanh(edge)))


@dataclass(frozen=True)
class CeilingLens:
    """A wide lens.

    Attributes:
        vignetting: fraction of the light that is missing in the corners, rising with the square of the distance.
        defocus: standard deviation of its point-spread function [px]; 0 is in focus.
        blooming: the glow about bright lamps.
        flares: lens flares, mirrored images of the lamps.
    """

    vignetting: float = 0.3
    defocus: float = 0.0
    blooming: Blooming = field(default_factory=Blooming)
    flares: tuple[LensFlare, ...] = ()

    @property
    def margin(self) -> float:
        """Distance from a lamp's edge beyond which it is not seen [px]."""
        return self.blooming.margin + 4.0 * self.defocus

    def transmission(self, camera: PinholeCamera) -> NDArray[np.float32]:
        """Return the fraction of the light that reaches each pixel, shape (height, width)."""
        u = np.arange(camera.width) - camera.cx
        v = np.arange(camera.height) - camera.cy
        corner = max(np.abs(u[[0, -1]])) ** 2 + max(np.abs(v[[0, -1]])) ** 2
        squares = (np.square(u)[None, :] + np.square(v)[:, None]) / corner
        return np.asarray(1.0 - self.vignetting * squares, dtype=np.float32)
