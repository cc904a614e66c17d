"""The light in a corridor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scene_simulator.corridor_surface import Surface, Vector

_MIDDLE = (0.0, 0.0, 1.3)
"""Where the light has its level: in the middle of the end wall, in the map frame [m]."""


@dataclass(frozen=True)
class CorridorLight:
    """Light that changes evenly over the corridor.

    Attributes:
        level: grey level of a white wall before the lens, 1 saturates.
        gradient: relative change along the axes of the map [1/m].
    """

    level: float = 0.95
    gradient: Vector = (0.015, 0.0, 0.09)

    def on_surface(self, surface: Surface) -> tuple[float, float, float]:
        """Return the light at the surface's origin and its slopes to the right and up [1/m]."""
        gradient: NDArray[np.float64] = self.level * np.array(self.gradient)
        at_origin = self.level + float(gradient @ (np.array(surface.origin) - _MIDDLE))
        return at_origin, float(gradient @ surface.right), float(gradient @ surface.up)
