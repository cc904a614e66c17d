"""The two halves of a split panel, one of which may be dark while the other is lit.

The intensity centroid alternates along the line between the halves, which determines the split axis. The brightness
levels of the halves, measured away from rim and split, then give the offset of the centroid from the middle.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shirube_core.geometry import rotation_matrix

RADIUS_FACTOR = 1.25
"""Radius of the centroid window [lamp radii]."""
FRAMES_MIN = 8
"""Number of frames before the split axis is used."""
JUMP_MIN = 0.15
"""Minimum RMS displacement of the centroid of a split lamp [lamp radii]."""
JUMP_FULL = 0.3
"""Displacement with full weight for the split axis [lamp radii]."""
FORGETTING_FACTOR = 0.85
"""Forgetting factor of the axis estimate per jump, because the axis rotates with the robot."""
HALF_DISC_CENTROID = 4.0 / (3.0 * math.pi)
"""Distance of a half disc's centroid from the disc centre [lamp radii]."""


@njit(cache=True)
def intensity_centroid(
    image: NDArray[np.uint8], middle: NDArray[np.float64], radius: float, background: float
) -> NDArray[np.float64]:
    """Return the intensity centroid around a position, shape (2,) [px]; the position itself if all is dark."""
    extent = RADIUS_FACTOR * radius + 1.0
    light, along = 0.0, np.zeros(2)
    for v in range(max(math.ceil(middle[1] - extent), 0), min(int(middle[1] + extent) + 1, image.shape[0])):
        half_width = math.sqrt(max(extent**2 - (v - middle[1]) ** 2, 0.0))
        for u in range(max(math.ceil(middle[0] - half_width), 0), min(int(middle[0] + half_width) + 1, image.shape[1])):
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
    image: NDArray[np.uint8], middle: NDArray[np.float64], radius: float, axis: NDArray[np.float64], background: float
) -> tuple[float, float]:
    """Return the brightness of both halves, away from rim and split [grey levels]; first the one along ``axis``.

    Args:
        image: grey image, shape (h, w).
        middle: centre of the lamp, shape (2,) [px].
        radius: lamp radius [px].
        axis: unit vector from the second half to the first, shape (2,).
        background: brightness of the background [grey levels].
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
    """Estimates the axis along which the centroid of a lamp alternates; without jumps the lamp has one part.

    Attributes:
        axis: unit vector of the split axis, shape (2,); the sign is arbitrary.
        is_split: whether the lamp has a split axis.
    """

    def __init__(self) -> None:
        """Start without an axis."""
        self._scatter = np.zeros((2, 2))
        self._power = 0.0
        self._frames = 0
        self.axis = np.array([1.0, 0.0])
        self.is_split = False

    @property
    def split_uncertainty(self) -> float:
        """Probability-like weight that a lamp without jumps is split after all, from 1 (new) to 0 (old)."""
        return max(1.0 - self._frames / (2.0 * FRAMES_MIN), 0.0)

    def add(self, offset: NDArray[np.float64], radius: float) -> None:
        """Add the offset of a frame's centroid from the predicted lamp centre, shape (2,) [px]."""
        jump = offset / radius
        power = float(jump @ jump)
        self._frames += 1
        self._power += (power - self._power) / min(self._frames, 2 * FRAMES_MIN)
        self._scatter = FORGETTING_FACTOR ** min(power / JUMP_FULL**2, 1.0) * self._scatter + np.outer(jump, jump)
        self.is_split |= self._frames >= FRAMES_MIN and self._power > JUMP_MIN**2
        # The sign of an eigenvector is arbitrary; keep it consistent while the robot turns.
        line = np.linalg.eigh(self._scatter)[1][:, 1]
        self.axis = line if line @ self.axis >= 0.0 else -line

    def rotate(self, angle: float) -> None:
        """Rotate the axis by the image rotation [rad], from u to v."""
        R = rotation_matrix(angle)
        self._scatter = R @ self._scatter @ R.T
        self.axis = R @ self.axis
