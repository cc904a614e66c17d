"""Lens model: vignetting, and the blooming of bright lamps, eq. (4) of the paper."""

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from scene_simulator.errors import SceneError
from shirube_core.geometry import PinholeCamera

_MAX_SLOPE = 3.0  # steepest edge that pixels still sample well [1/px]: as soft as 0.6 px of standard deviation make it


@dataclass(frozen=True)
class Blooming:
    """How the image of a lamp fades beyond its edge.

    At a distance d = delta - p from the edge of a lamp of brightness b, eq. (4) of the paper, whose last bracket is
    one place off in print, gives ``(b - gamma) (1 - sigma(alpha (d - beta))) + gamma``. It is used inside the
    edge too, where it differs from b by no more than b exp(-alpha beta), 0.25 %: so there is no step at d = 0.
    The glow gamma does not reach for ever: beyond ``glow_reach`` it fades to nothing at twice that distance.

    Attributes:
        slope: alpha, above 0 to 3 [1/px].
        spread: beta, how far beyond the edge the half brightness is seen [px].
        glow: gamma relative to b, 0 to 1; the default fits a real lamp, as the others do: 48 of 255.
        glow_reach: distance from the edge up to which the glow holds its level [px].
    """

    slope: float = 2.4
    spread: float = 2.5
    glow: float = 48.0 / 255.0
    glow_reach: float = 12.0

    def __post_init__(self) -> None:
        """Refuse what no lens does or pixels cannot show with a SceneError."""
        if not (0.0 < self.slope <= _MAX_SLOPE and 0.0 <= self.spread < math.inf):
            raise SceneError(f'blooming has slope {self.slope} and spread {self.spread}: give above 0 to 3, 0 or more')
        if not (0.0 <= self.glow <= 1.0 and 0.0 < self.glow_reach < math.inf):
            raise SceneError(f'blooming has glow {self.glow} and reach {self.glow_reach}: give 0 to 1, above 0')

    @property
    def parameters(self) -> tuple[float, float, float, float]:
        """What the compiled functions need: slope, spread, glow and its reach."""
        return self.slope, self.spread, self.glow, self.glow_reach

    @property
    def margin(self) -> float:
        """Distance from the edge beyond which a lamp is not seen [px]."""
        edge = self.spread + 12.0 / self.slope
        return max(edge, 2.0 * self.glow_reach) if self.glow > 0.0 else edge

    def profile(self, distances: ArrayLike) -> NDArray[np.float64]:
        """Return the brightness relative to b at signed distances from the edge, outside positive [px]."""
        flat = np.asarray(distances, dtype=np.float64)
        edge = [edge_light(float(distance), self.parameters) for distance in flat.ravel()]
        glow = [glow_light(float(distance), self.parameters) for distance in flat.ravel()]
        return np.asarray(glow + (1.0 - np.array(glow)) * edge).reshape(flat.shape)


SHARP = Blooming(slope=_MAX_SLOPE, spread=0.0, glow=0.0)  # a lens without blooming


@njit(cache=True)
def edge_light(distance: float, parameters: tuple[float, float, float, float]) -> float:
    """Return 1 - sigma(alpha (distance - beta)), never quite 0, at a signed distance from the edge [px]."""
    exponent = parameters[0] * (distance - parameters[1])
    return 1.0 if exponent < -40.0 else 1.0 / (1.0 + math.exp(min(exponent, 80.0)))


@njit(cache=True)
def glow_light(distance: float, parameters: tuple[float, float, float, float]) -> float:
    """Return gamma, as far as it reaches, at a signed distance from the edge [px]."""
    glow, reach = parameters[2], parameters[3]
    if distance <= reach:
        return glow
    if distance >= 2.0 * reach:
        return 0.0
    return glow * (0.5 + 0.5 * math.cos(math.pi * (distance / reach - 1.0)))


@dataclass(frozen=True)
class CeilingLens:
    """A wide lens: fraction of the light that is missing in the corners (grows with the square), and its blooming."""

    vignetting: float = 0.3
    blooming: Blooming = field(default_factory=Blooming)

    def transmission(self, camera: PinholeCamera) -> NDArray[np.float32]:
        """Return the fraction of the light that reaches each pixel, shape (height, width)."""
        u = np.arange(camera.width) - camera.cx
        v = np.arange(camera.height) - camera.cy
        corner = max(np.abs(u[[0, -1]])) ** 2 + max(np.abs(v[[0, -1]])) ** 2
        squares = (np.square(u)[None, :] + np.square(v)[:, None]) / corner
        return np.asarray(1.0 - self.vignetting * squares, dtype=np.float32)
