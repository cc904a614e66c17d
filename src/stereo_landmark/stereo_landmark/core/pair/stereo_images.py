"""Synchronized, rectified stereo images."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class StereoImages:
    """A stereo pair.

    Attributes:
        left: rectified grey image of the left camera, shape (h, w).
        right: rectified grey image of the right camera, shape (h, w).
        tilt: roll and pitch of the base at the stamp of the images [rad].
    """

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    tilt: tuple[float, float] = (0.0, 0.0)
