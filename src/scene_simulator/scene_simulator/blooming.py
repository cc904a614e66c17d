"""The glow about a bright lamp, eq. (4) of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Blooming:
    """How the image of a lamp fades beyond its edge.

    At a distance d = delta - p from the edge of a lamp of brightness b, eq. (4) of the paper, whose last bracket is
    one place off in print, gives ``(b - gamma) (1 - sigma(alpha (d - beta))) + gamma``. It is used inside the
    edge too, where it differs from b by no more than b exp(-alpha beta), 0.25 %: so there is no step at d = 0.
    The glow gamma does not reach for ever: beyond ``glow_reach`` it fades to nothing at twice that distance.

    Attributes:
        slope: alpha [1/px].
        spread: beta, how far beyond the edge the half brightness is seen [px].
        glow: gamma relative to b; the default fits a real lamp, as the others do: 48 of 255.
        glow_reach: distance from the edge up to which the glow holds its level [px].
    """

    slope: float = 2.4
    spread: float = 2.5
    glow: float = 48.0 / 255.0
    glow_reach: float = 12.0

    @property
    def margin(self) -> float:
        """Distance from the edge beyond which a lamp is not seen [px]."""
        edge = self.spread + 12.0 / self.slope
        return max(edge, 2.0 * self.glow_reach) if self.glow > 0.0 else edge

    def profile(self, distances: ArrayLike) -> NDArray[np.float64]:
        """Return the brightness relative to b at signed distances from the edge, outside positive [px]."""
        d = np.asarray(distances, dtype=np.float64)
        outside = 0.5 + 0.5 * np.tanh(0.5 * self.slope * (d - self.spread))
        fading = np.clip(d / self.glow_reach - 1.0, 0.0, 1.0)
        glow = self.glow * (0.5 + 0.5 * np.cos(math.pi * fading))
        return np.asarray(1.0 - outside + glow * outside)


SHARP = Blooming(slope=4.0, spread=0.0, glow=0.0)
"""A lens without blooming: the edge is as soft as a point of 0.45 px standard deviation makes it."""
