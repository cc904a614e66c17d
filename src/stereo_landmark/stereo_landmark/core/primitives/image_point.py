"""Image point with covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ImagePoint:
    """A measured point in one image.

    Attributes:
        position: pixel coordinates, shape (2,) [px].
        covariance: covariance of the position, shape (2, 2) [px²].
    """

    position: NDArray[np.float64]
    covariance: NDArray[np.float64]
