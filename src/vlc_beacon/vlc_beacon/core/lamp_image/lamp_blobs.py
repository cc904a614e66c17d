"""Detected lamps of one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LampBlobs:
    """Bright round blobs.

    Attributes:
        centroids: centroids (u, v), shape (n, 2) [px].
        sigmas: standard deviations of the centroids along u and v, shape (n, 2) [px].
        radii: half-maximum radii including blooming, shape (n,) [px].
        roundness: width over length, 1 for a disc, shape (n,).
        brightness: brightness above the background, shape (n,) [grey levels].
        backgrounds: brightness of the background, shape (n,) [grey levels].
    """

    centroids: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    radii: NDArray[np.float64]
    roundness: NDArray[np.float64]
    brightness: NDArray[np.float64]
    backgrounds: NDArray[np.float64]

    def __len__(self) -> int:
        """Return the number of blobs."""
        return len(self.centroids)
