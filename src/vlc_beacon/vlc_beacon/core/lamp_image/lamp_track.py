"""Track of one lamp from frame to frame, also while it is dark or half dark."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shirube_core.geometry import rotation_matrix
from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs

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


SPEED_SIGMA = 250.0
"""Initial standard deviation of the image velocity [px/s]."""
ACCELERATION_SIGMA = 800.0
"""Process noise [px/s^2]; lamps far from the image centre move fast when the robot turns in place."""


class ImageMotion:
    """Constant-velocity Kalman filter of a lamp's place at a time ``stamp`` [s], with equal noise along u and v."""

    def __init__(self, stamp: float, position: NDArray[np.float64], sigma: float) -> None:
        """Initialize with a position, shape (2,) [px], and its standard deviation ``sigma`` [px]."""
        self.stamp = stamp
        self._state = np.stack([position, np.zeros(2)])
        self._covariance = np.diag([sigma**2, SPEED_SIGMA**2])

    def predict(self, stamp: float) -> tuple[NDArray[np.float64], float]:
        """Return the predicted position, shape (2,), and its standard deviation per axis at a time [px]."""
        state, covariance = self._predict_state(stamp)
        return state[0], float(np.sqrt(covariance[0, 0]))

    def coast(self, stamp: float) -> None:
        """Advance the state to a time without a measurement."""
        self._state, self._covariance = self._predict_state(stamp)
        self.stamp = stamp

    def update(self, stamp: float, position: NDArray[np.float64], sigma: float) -> None:
        """Advance the state to a time and update it with a measured position, shape (2,), of ``sigma`` [px]."""
        self.coast(stamp)
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + sigma**2)
        self._state = self._state + gain[:, None] * (position - self._state[0])
        self._covariance = self._covariance - np.outer(gain, self._covariance[0])

    def _predict_state(self, stamp: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        step = max(stamp - self.stamp, 0.0)
        F = np.array([[1.0, step], [0.0, 1.0]])
        G = np.array([0.5 * step**2, step])
        return F @ self._state, F @ self._covariance @ F.T + ACCELERATION_SIGMA**2 * np.outer(G, G)


HALF_JUMP = 0.3
"""Standard deviation of the centroid of a lamp whose halves may go dark [lamp radii]."""
MIDDLE_SIGMA = 0.02
"""Standard deviation of the centre of a half dark lamp, computed from the levels of its halves [lamp radii]."""
GATE_SIGMAS = 4.0
FAINT_LEVEL = 0.06
"""A lamp whose halves are both below this fraction of full brightness gives no position measurement."""
RADIUS_DECAY, FULL_DECAY = 0.998, 0.9995
"""Decay of the maximum radius and brightness per frame."""
HALF_PRIOR_FRAMES = 10.0
"""Weight, in frames, of the theoretical half-disc centroid distance when it is learned."""


class LampTrack:
    """A tracked lamp.

    Attributes:
        key: unique track ID.
        centre: centre in the last frame, shape (2,), predicted if the lamp was dark [px].
        sigma: standard deviation of the centre, shape (2,), infinite if the lamp was dark [px].
        radius: lamp radius [px].
        last_seen: stamp of the last frame in which the lamp was lit [s].
    """

    def __init__(self, key: int, stamp: float, blobs: LampBlobs, i: int, *, may_be_split: bool) -> None:
        """Create a track from blob ``i`` of a frame, whose halves may be switched independently or not."""
        self.key = key
        self.centre, self.sigma = blobs.centroids[i].copy(), blobs.sigmas[i].copy()
        self.radius = float(blobs.radii[i])
        self.last_seen = stamp
        self._background = float(blobs.backgrounds[i])
        self._motion = ImageMotion(stamp, self.centre, HALF_JUMP * self.radius)
        self._split = SplitAxis() if may_be_split else None
        self._full = 1e-9
        self._half_sums = np.array([HALF_DISC_CENTROID * HALF_PRIOR_FRAMES, HALF_PRIOR_FRAMES])

    @property
    def split_axis(self) -> NDArray[np.float64] | None:
        """Unit vector from the second half to the first, shape (2,); None for a lamp of one part."""
        return self._split.axis if self._split is not None and self._split.is_split else None

    def predict(self, stamp: float) -> tuple[NDArray[np.float64], float]:
        """Return the predicted centre, shape (2,), and the gate radius [px]."""
        centre, sigma = self._motion.predict(stamp)
        return centre, GATE_SIGMAS * math.hypot(sigma, HALF_JUMP * self.radius) + 1.0

    def rotate(self, angle: float) -> None:
        """Account for the image rotation since the last frame [rad], from u to v."""
        if self._split is not None:
            self._split.rotate(angle)

    def update(self, stamp: float, image: NDArray[np.uint8], blobs: LampBlobs, i: int) -> NDArray[np.float64]:
        """Update with a detection and return the brightness of the halves relative to full light, shape (2,)."""
        expected, _ = self._motion.predict(stamp)
        self.radius = max(RADIUS_DECAY * self.radius, float(blobs.radii[i]))
        self._background = float(blobs.backgrounds[i])
        self.centre, self.sigma = blobs.centroids[i].copy(), blobs.sigmas[i].copy()
        if self._split is not None:
            self._locate_middle(self._split, image, expected)
        self.last_seen = stamp
        half_brightness = self._half_brightness(image)
        if half_brightness.max() < FAINT_LEVEL:
            self._coast(stamp)
        else:
            self._motion.update(stamp, self.centre, float(self.sigma.max()))
        return half_brightness

    def miss(self, stamp: float, image: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Update with a frame without a detection and return the brightness of the halves, as `update` does."""
        self._coast(stamp)
        return self._half_brightness(image)

    def _coast(self, stamp: float) -> None:
        """Use the predicted position."""
        self._motion.coast(stamp)
        self.centre, _ = self._motion.predict(stamp)
        self.sigma = np.full(2, math.inf)

    def _locate_middle(self, split: SplitAxis, image: NDArray[np.uint8], expected: NDArray[np.float64]) -> None:
        """Set centre and sigma of a lamp whose halves may differ in brightness."""
        near = intensity_centroid(image, expected, self.radius, self._background)
        split.add(near - expected, self.radius)
        if not split.is_split:
            # A lamp without jumps for long has one part.
            self.sigma = np.hypot(self.sigma, HALF_JUMP * self.radius * split.split_uncertainty)
            return
        middle = expected
        for _ in range(2):
            first, second = self._half_levels(image, middle)
            imbalance = (first - second) / max(first + second, 1e-9)
            distance = float(self._half_sums[0] / self._half_sums[1])
            centroid = intensity_centroid(image, middle, self.radius, self._background)
            middle = centroid - imbalance * distance * self.radius * split.axis
        jump = float((centroid - expected) @ split.axis) / self.radius
        self._half_sums = 0.99 * self._half_sums + np.array([jump * imbalance, imbalance * imbalance])
        self.centre = middle
        self.sigma = np.hypot(self.sigma, MIDDLE_SIGMA * self.radius * (1.0 + 2.0 * abs(imbalance)))

    def _half_levels(self, image: NDArray[np.uint8], middle: NDArray[np.float64]) -> tuple[float, float]:
        axis = np.array([1.0, 0.0]) if self._split is None else self._split.axis
        first, second = half_levels(image, middle, self.radius, axis, self._background)
        return max(first, 0.0), max(second, 0.0)

    def _half_brightness(self, image: NDArray[np.uint8]) -> NDArray[np.float64]:
        half_brightness = np.array(self._half_levels(image, self.centre))
        self._full = max(FULL_DECAY * self._full, float(half_brightness.max()))
        return half_brightness / self._full
