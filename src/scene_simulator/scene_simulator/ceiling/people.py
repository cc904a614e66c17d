"""People between the camera and the ceiling: dark upright cylinders that occlude what is behind them."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from scene_simulator.errors import SceneError


@dataclass(frozen=True)
class Person:
    """A person who walks to and fro between two places.

    Attributes:
        start: x, y at time 0 in the map frame [m].
        end: x, y where the person turns round [m].
        height: z of the top of the head in the map frame [m].
        speed: walking speed, 0 for a person who stands at the start [m/s].
        radius: half the width of the shoulders [m].
    """

    start: tuple[float, float]
    end: tuple[float, float]
    height: float
    speed: float = 1.2
    radius: float = 0.22

    def __post_init__(self) -> None:
        """Refuse sizes and speeds that are not positive with a SceneError."""
        if not (0.0 < self.radius < math.inf and 0.0 <= self.speed < math.inf):
            raise SceneError(f'a person has radius {self.radius} m and speed {self.speed} m/s: give positive ones')

    def position_at(self, time: float) -> tuple[float, float]:
        """Return x, y at a time [s] in the map frame [m]."""
        length = math.dist(self.start, self.end)
        phase = self.speed * time / length % 2.0 if length > 0.0 else 0.0
        share = min(phase, 2.0 - phase)
        x, y = (a + share * (b - a) for a, b in zip(self.start, self.end, strict=True))
        return x, y


@njit(cache=True)
def occlude(
    light: NDArray[np.float32],
    rays: NDArray[np.float64],
    R_map_camera: NDArray[np.float64],
    cylinder: tuple[float, float, float, float],
) -> None:
    """Remove the light behind a person from a picture.

    Args:
        light: shape (height, width), changed in place.
        rays: shape (height + 2, width + 2, 2), rays of the pixels and of a border of one pixel, z = 1.
        R_map_camera: shape (3, 3).
        cylinder: x, y and top of the person relative to the camera, in the axes of the map, and radius [m].
    """
    px, py, top, radius = cylinder
    r = R_map_camera
    for row in range(light.shape[0]):
        for column in range(light.shape[1]):
            u, v = rays[row + 1, column + 1]
            dx = r[0, 0] * u + r[0, 1] * v + r[0, 2]
            dy = r[1, 0] * u + r[1, 1] * v + r[1, 2]
            dz = r[2, 0] * u + r[2, 1] * v + r[2, 2]
            if dz <= 0.0 or top <= 0.0:
                continue
            # The point of the ray below the top that is nearest to the axis.
            nearest = (px * dx + py * dy) / max(dx * dx + dy * dy, 1e-12)
            s = min(max(nearest, 0.0), top / dz)
            if (s * dx - px) ** 2 + (s * dy - py) ** 2 < radius * radius:
                light[row, column] = 0.0
