"""Which dots a floor has: darker than it, lighter, or of any colour."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.background import smooth_background

# Reflections and dust also differ from the floor; chips of a second kind make up more than this.
_SECOND_KIND = 0.4
_COLOUR_EXCESS = 1.3
_SATURATED = 250
# Of a dark floor, whole grey levels are coarse steps [grey levels].
_ROUNDING = 4.0
_COARSE_SIZE = 90.0


def choose_polarity(image: NDArray[np.uint8], largest_diameter: float) -> str:
    """Return ``dark``, ``light`` or ``any``: the kind of which there are most; their size does not count.

    Args:
        image: shape (h, w, channels), grey levels.
        largest_diameter: diameter of the largest dot [px].
    """
    # Whole multiples of the coarse pixel: OpenCV averages them many times faster than parts.
    factor = max(1, round(max(image.shape) / _COARSE_SIZE))
    height, width, channels = image.shape[0] // factor, image.shape[1] // factor, image.shape[2]
    whole = image[: height * factor, : width * factor]
    coarse = cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA).reshape(height, width, channels)
    background = smooth_background(coarse, 'any', largest_diameter / factor)
    difference = coarse / background - 1.0
    difference[coarse.max(axis=2) >= _SATURATED] = 0.0
    brightness = difference.mean(axis=2)
    noise = 1.4826 * float(np.median(np.abs(brightness)))
    threshold = np.maximum(max(0.05, 5.0 * noise), _ROUNDING / background.mean(axis=2))
    dark, light = _blobs(brightness < -threshold), _blobs(brightness > threshold)
    coloured = _blobs(np.sqrt((difference**2).mean(axis=2)) > threshold)
    if min(dark, light) > _SECOND_KIND * max(dark, light) or coloured > _COLOUR_EXCESS * max(dark, light):
        return 'any'
    return 'dark' if dark >= light else 'light'


def _blobs(mask: NDArray[np.bool_]) -> int:
    return int(cv2.connectedComponents(mask.astype(np.uint8))[0]) - 1
