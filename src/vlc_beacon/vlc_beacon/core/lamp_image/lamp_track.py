"""One lamp from frame to frame: where it is, though it may be dark or half dark."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.image_motion import ImageMotion
from vlc_beacon.core.lamp_image.lamp_blobs import LampBlobs
from vlc_beacon.core.lamp_image.lamp_parts import HALF_DISC, SplitAxis, half_levels, light_centroid

HALF_JUMP = 0.3
"""Standard deviation of the centroid of a lamp whose halves may go dark. [radii]"""
MIDDLE_ERROR = 0.02
"""Of the middle of a half dark lamp, which follows from the levels of its halves. [radii]"""
GATE_SIGMAS = 4.0
FAINT = 0.06
"""A lamp whose halves both are darker than this share of their full brightness does not tell where it is."""
RADIUS_KEPT, FULL_KEPT = 0.998, 0.9995
"""Share of the largest radius and brightness that is kept from frame to frame."""
HALF_FRAMES = 10.0
"""The distance of a half's centroid is learned; so many frames weigh the disc's."""


class LampTrack:
    """A lamp that is followed.

    Attributes:
        key: tells it from all others.
        place: shape (2,), of its middle at the last frame, expected if it was dark then [px].
        sigma: shape (2,), standard deviation of ``place``, infinite if it was dark [px].
        radius: [px].
        last_seen: stamp of the last frame in which it was not dark [s].
    """

    def __init__(self, key: int, stamp: float, blobs: LampBlobs, i: int, *, may_be_split: bool) -> None:
        """Begin with a blob.

        Args:
            key: tells it from all others.
            stamp: of the frame [s].
            blobs: of the frame.
            i: the lamp among them.
            may_be_split: whether its halves may go dark one by one.
        """
        self.key = key
        self.place, self.sigma = blobs.centroids[i].copy(), blobs.sigmas[i].copy()
        self.radius = float(blobs.radii[i])
        self.last_seen = stamp
        self._background = float(blobs.backgrounds[i])
        self._motion = ImageMotion(stamp, self.place, HALF_JUMP * self.radius)
        self._split = SplitAxis() if may_be_split else None
        self._full = 1e-9
        self._half_sums = np.array([HALF_DISC * HALF_FRAMES, HALF_FRAMES])

    @property
    def split_axis(self) -> NDArray[np.float64] | None:
        """From the second half to the first, shape (2,), of length 1; None for a lamp of one part."""
        return self._split.axis if self._split is not None and self._split.is_split else None

    def expect(self, stamp: float) -> tuple[NDArray[np.float64], float]:
        """Return where the lamp is expected, shape (2,), and how far from there it may be found [px]."""
        place, sigma = self._motion.expect(stamp)
        return place, GATE_SIGMAS * math.hypot(sigma, HALF_JUMP * self.radius) + 1.0

    def turn(self, angle: float) -> None:
        """Take that the image turned by an angle [rad] since the last frame, from u to v."""
        if self._split is not None:
            self._split.turn(angle)

    def see(self, stamp: float, image: NDArray[np.uint8], blobs: LampBlobs, i: int) -> NDArray[np.float64]:
        """Take a frame in which the lamp was found and return the brightness of its halves, shape (2,), 1 for full."""
        expected, _ = self._motion.expect(stamp)
        self.radius = max(RADIUS_KEPT * self.radius, float(blobs.radii[i]))
        self._background = float(blobs.backgrounds[i])
        self.place, self.sigma = blobs.centroids[i].copy(), blobs.sigmas[i].copy()
        if self._split is not None:
            self._find_middle(self._split, image, expected)
        self.last_seen = stamp
        parts = self._parts(image)
        if parts.max() < FAINT:
            self._coast(stamp)
        else:
            self._motion.see(stamp, self.place, float(self.sigma.max()))
        return parts

    def miss(self, stamp: float, image: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Take a frame in which the lamp was not found and return the brightness of its halves as `see` does."""
        self._coast(stamp)
        return self._parts(image)

    def _coast(self, stamp: float) -> None:
        """Take the lamp to be where it is expected."""
        self._motion.coast(stamp)
        self.place, _ = self._motion.expect(stamp)
        self.sigma = np.full(2, math.inf)

    def _find_middle(self, split: SplitAxis, image: NDArray[np.uint8], expected: NDArray[np.float64]) -> None:
        """Set place and sigma of a lamp whose halves may differ."""
        near = light_centroid(image, expected, self.radius, self._background)
        split.add(near - expected, self.radius)
        if not split.is_split:
            # A lamp that did not jump for long has one part.
            self.sigma = np.hypot(self.sigma, HALF_JUMP * self.radius * split.doubt)
            return
        middle = expected
        for _ in range(2):
            first, second = self._levels(image, middle)
            lean = (first - second) / max(first + second, 1e-9)
            distance = float(self._half_sums[0] / self._half_sums[1])
            centroid = light_centroid(image, middle, self.radius, self._background)
            middle = centroid - lean * distance * self.radius * split.axis
        jump = float((centroid - expected) @ split.axis) / self.radius
        self._half_sums = 0.99 * self._half_sums + np.array([jump * lean, lean * lean])
        self.place = middle
        self.sigma = np.hypot(self.sigma, MIDDLE_ERROR * self.radius * (1.0 + 2.0 * abs(lean)))

    def _levels(self, image: NDArray[np.uint8], middle: NDArray[np.float64]) -> tuple[float, float]:
        axis = np.array([1.0, 0.0]) if self._split is None else self._split.axis
        first, second = half_levels(image, middle, self.radius, axis, self._background)
        return max(first, 0.0), max(second, 0.0)

    def _parts(self, image: NDArray[np.uint8]) -> NDArray[np.float64]:
        parts = np.array(self._levels(image, self.place))
        self._full = max(FULL_KEPT * self._full, float(parts.max()))
        return parts / self._full
