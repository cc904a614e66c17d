"""A point of a landmark in one image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ImagePoint:
    """Where a point is seen, and how well that is known.

    Attributes:
        position: shape (2,) [px].
        covariance: shape (2, 2) [px²].
    """

    position: NDArray[np.float64]
    covariance: NDArray[np.float64]
