"""Brightness of a lamp row by row, as a rolling shutter sees it blink."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

REACH = 3.0
"""The halo of a bright lamp blinks too; rows are taken as far as it shows. [radii]"""
COLUMNS = 0.6
"""Half the width over which a row is averaged. [radii]"""
SIGMAS = 5.0
LEVELS_MIN = 3.0
"""A row tells nothing where the lamp is less bright over its background [grey levels]."""


def row_profile(
    image: NDArray[np.uint8],
    centre: NDArray[np.float64],
    radius: float,
    background: float,
    stripe_rows: float,
    noise: float = 1.0,
) -> tuple[int, NDArray[np.float64]]:
    """Return the first row and the brightness of the rows over the lamp's own envelope, shape (m,), about 0 to 1.

    Dividing by the envelope (the brightest rows nearby) makes rows near the rim and in the halo as good as others.

    Args:
        image: shape (h, w).
        centre: shape (2,) [px].
        radius: of the lamp [px].
        background: around the lamp [grey levels].
        stripe_rows: longest dark stripe in the lamp [px].
        noise: of a pixel [grey levels].
    """
    height, width = image.shape
    first = max(math.ceil(centre[1] - REACH * radius), 0)
    after = min(int(centre[1] + REACH * radius) + 1, height)
    left = max(math.ceil(centre[0] - COLUMNS * radius), 0)
    right = min(int(centre[0] + COLUMNS * radius) + 1, width)
    if first >= after or left >= right:
        return first, np.empty(0)
    levels = image[first:after, left:right].mean(axis=1) - background
    # The largest within a stripe and a quarter, so that each place sees a bright row.
    side = 1 + 2 * math.ceil(0.625 * stripe_rows)
    envelope = cv2.dilate(levels[:, None], np.ones((side, 1), np.uint8))
    envelope = cv2.GaussianBlur(envelope, (0, 0), max(0.4 * stripe_rows, 0.5))[:, 0]
    shown = envelope >= max(LEVELS_MIN, SIGMAS * noise / math.sqrt(right - left))
    middle = min(max(round(float(centre[1])) - first, 0), len(levels) - 1)
    if not shown[middle]:
        return first + middle, np.empty(0)
    dark = np.flatnonzero(~shown)
    begin = int(dark[dark < middle].max(initial=-1)) + 1
    end = int(dark[dark > middle].min(initial=len(levels)))
    return first + begin, levels[begin:end] / envelope[begin:end]
