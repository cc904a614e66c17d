"""Track of one lamp from frame to frame, also while it is dark or half dark."""

import math

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs
from vlc_beacon.core.lamp_image.lamp_halves import HALF_DISC_CENTROID, SplitAxis, half_levels, intensity_centroid

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
