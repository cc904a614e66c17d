"""Lamps in one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LampBlobs:
    """Bright round spots.

    Attributes:
        centroids: shape (n, 2), u and v [px].
        sigmas: shape (n, 2), their standard deviation along u and along v [px].
        radii: shape (n,), where half the brightness is reached, with blooming [px].
        roundness: shape (n,), width over length, 1 for a disc.
        brightness: shape (n,), of the lamp over what is around it [grey levels].
        backgrounds: shape (n,), what is around it [grey levels].
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
