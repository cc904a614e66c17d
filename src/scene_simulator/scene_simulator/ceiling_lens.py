"""What a lens does to the light of lamps: vignetting, defocus, blooming and ghosts."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from scene_simulator.blooming import Blooming
from shirube_geometry import PinholeCamera

_GHOST_SOFTNESS = 1.0
"""Slope of a ghost's edge [1/px]."""


@dataclass(frozen=True)
class LensGhost:
    """A faint image of every lamp, mirrored between the lenses, at ``scale`` times its place from the middle.

    Attributes:
        scale: place relative to the principal point; negative lies on the other side.
        strength: brightness relative to the lamp.
        radius: of the spot [px].
    """

    scale: float = -0.55
    strength: float = 0.04
    radius: float = 9.0

    @property
    def margin(self) -> float:
        """Distance from its middle beyond which a ghost is not seen [px]."""
        return self.radius + 12.0 / _GHOST_SOFTNESS

    def profile(self, distances: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the brightness relative to the lamp at distances from the ghost's middle [px]."""
        edge = 0.5 * _GHOST_SOFTNESS * (distances - self.radius)
        return np.asarray(self.strength * (0.5 - 0.5 * np.tanh(edge)))


@dataclass(frozen=True)
class CeilingLens:
    """A wide lens.

    Attributes:
        vignetting: share of the light that is missing in the corners, rising with the square of the distance.
        defocus: standard deviation of its point-spread function [px]; 0 is in focus.
        blooming: the glow about bright lamps.
        ghosts: mirrored images of the lamps.
    """

    vignetting: float = 0.3
    defocus: float = 0.0
    blooming: Blooming = field(default_factory=Blooming)
    ghosts: tuple[LensGhost, ...] = ()

    @property
    def margin(self) -> float:
        """Distance from a lamp's edge beyond which it is not seen [px]."""
        return self.blooming.margin + 4.0 * self.defocus

    def transmission(self, camera: PinholeCamera) -> NDArray[np.float32]:
        """Return the share of the light that reaches each pixel, shape (height, width)."""
        u = np.arange(camera.width) - camera.cx
        v = np.arange(camera.height) - camera.cy
        corner = max(np.abs(u[[0, -1]])) ** 2 + max(np.abs(v[[0, -1]])) ** 2
        squares = (np.square(u)[None, :] + np.square(v)[:, None]) / corner
        return np.asarray(1.0 - self.vignetting * squares, dtype=np.float32)
