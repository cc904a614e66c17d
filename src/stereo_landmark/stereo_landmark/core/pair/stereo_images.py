"""Two images of one moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class StereoImages:
    """A pair of images.

    Attributes:
        left: shape (h, w), grey, rectified.
        right: the same of the right camera.
        tilt: roll and pitch of the base at that moment [rad].
    """

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    tilt: tuple[float, float] = (0.0, 0.0)
