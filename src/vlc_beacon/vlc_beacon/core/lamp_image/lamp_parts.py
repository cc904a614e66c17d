"""The two halves of a split panel, of which one may be dark while the other is lit.

The centroid of the light jumps to and fro along the line from half to half; that tells the line. The levels of the
halves, taken away from rim and split, then tell how far the centroid is off the middle.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

REACH = 1.25
"""Light is gathered from so far around the middle. [radii]"""
FRAMES_MIN = 8
"""The line is believed after so many frames."""
JUMP_MIN = 0.15
"""Halves that go dark make the centroid jump by more, root mean square. [radii]"""
JUMP_FULL = 0.3
"""A jump by so much tells the line. [radii]"""
KEPT = 0.85
"""Share of what is known of the line that is kept from jump to jump: it turns with the robot."""
HALF_DISC = 4.0 / (3.0 * math.pi)
"""Distance of a half disc's centroid from the middle. [radii]"""


@njit(cache=True)
def light_centroid(
    image: NDArray[np.uint8], middle: NDArray[np.float64], radius: float, background: float
) -> NDArray[np.float64]:
    """Return the centroid of the light around a place, shape (2,) [px]; the place itself where there is no light."""
    reach = REACH * radius + 1.0
    light, along = 0.0, np.zeros(2)
    for v in range(max(math.ceil(middle[1] - reach), 0), min(int(middle[1] + reach) + 1, image.shape[0])):
        wide = math.sqrt(max(reach**2 - (v - middle[1]) ** 2, 0.0))
        for u in range(max(math.ceil(middle[0] - wide), 0), min(int(middle[0] + wide) + 1, image.shape[1])):
            above = image[v, u] - background
            light += above
            along[0] += above * (u - middle[0])
            along[1] += above * (v - middle[1])
    if light <= 0.0:
        return middle.copy()
    offset = along / light
    return middle + offset * min(1.0, radius / max(np.hypot(offset[0], offset[1]), 1e-9))


@njit(cache=True)
def half_levels(
    image: NDArray[np.uint8],
    middle: NDArray[np.float64],
    radius: float,
    axis: NDArray[np.float64],
    background: float,
) -> tuple[float, float]:
    """Return the brightness within both halves, away from rim and split [grey levels], the one along ``axis`` first.

    Args:
        image: shape (h, w).
        middle: shape (2,), of the lamp [px].
        radius: [px].
        axis: shape (2,), unit vector from the second half to the first.
        background: around the lamp [grey levels].
    """
    sums, counts = np.zeros(2), np.zeros(2)
    top, bottom = max(math.ceil(middle[1] - radius), 0), min(int(middle[1] + radius) + 1, image.shape[0])
    left, right = max(math.ceil(middle[0] - radius), 0), min(int(middle[0] + radius) + 1, image.shape[1])
    for v in range(top, bottom):
        for u in range(left, right):
            x, y = u - middle[0], v - middle[1]
            along = x * axis[0] + y * axis[1]
            if x * x + y * y <= (0.75 * radius) ** 2 and abs(along) >= 0.2 * radius:
                half = 0 if along > 0.0 else 1
                sums[half] += image[v, u] - background
                counts[half] += 1.0
    return sums[0] / max(counts[0], 1.0), sums[1] / max(counts[1], 1.0)


class SplitAxis:
    """Learns along which line the centroid of a lamp jumps; without jumps the lamp has one part.

    Attributes:
        axis: shape (2,), unit vector along the line; either end may be the first half.
        is_split: whether there is such a line.
    """

    def __init__(self) -> None:
        """Begin without a line."""
        self._scatter = np.zeros((2, 2))
        self._power = 0.0
        self._frames = 0
        self.axis = np.array([1.0, 0.0])
        self.is_split = False

    @property
    def doubt(self) -> float:
        """How much the lamp may be split though it did not jump so far, 1 for a new lamp and 0 for an old one."""
        return max(1.0 - self._frames / (2.0 * FRAMES_MIN), 0.0)

    def add(self, offset: NDArray[np.float64], radius: float) -> None:
        """Take the offset of a frame's centroid from the lamp's expected middle, shape (2,) [px]."""
        jump = offset / radius
        power = float(jump @ jump)
        self._frames += 1
        self._power += (power - self._power) / min(self._frames, 2 * FRAMES_MIN)
        self._scatter = KEPT ** min(power / JUMP_FULL**2, 1.0) * self._scatter + np.outer(jump, jump)
        self.is_split |= self._frames >= FRAMES_MIN and self._power > JUMP_MIN**2
        # The line has two ends; the one that was the first stays it while the robot turns.
        line = np.linalg.eigh(self._scatter)[1][:, 1]
        self.axis = line if line @ self.axis >= 0.0 else -line

    def turn(self, angle: float) -> None:
        """Take that the image turned by an angle [rad], from u to v."""
        cos, sin = math.cos(angle), math.sin(angle)
        R = np.array([[cos, -sin], [sin, cos]])
        self._scatter = R @ self._scatter @ R.T
        self.axis = R @ self.axis
