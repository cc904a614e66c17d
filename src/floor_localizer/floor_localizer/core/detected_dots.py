"""What dot extraction hands to matching: the dots of one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class DetectedDots:
    """Dots found in one image, in the raw (distorted) image's coordinates.

    Attributes:
        pixels: shape (n, 2), centroids u and v [px]; the origin is the centre of the upper left pixel.
        diameters: shape (n,), diameter of the disc of equal area [px].
        sigmas: shape (n,), standard deviation of a centroid along each axis [px].
    """

    pixels: NDArray[np.float64]
    diameters: NDArray[np.float64]
    sigmas: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.pixels)
