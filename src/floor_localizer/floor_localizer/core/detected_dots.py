"""The dots of one image: output of dot extraction, input of matching."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class DetectedDots:
    """Dots detected in one image, in coordinates of the raw (distorted) image.

    Attributes:
        pixels: shape (n, 2), centroids u and v [px]; the origin is the centre of the upper left pixel.
        diameters: shape (n,), diameters of discs of equal area [px].
        sigmas: shape (n,), standard deviations of the centroids along each axis [px].
    """

    pixels: NDArray[np.float64]
    diameters: NDArray[np.float64]
    sigmas: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of dots."""
        return len(self.pixels)
