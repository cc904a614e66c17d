"""Background luminance smoothing (paper 3.1): what the floor would look like without dots."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

# The floor varies slowly: a coarser image, in which the largest dot has about this size, shows it as well.
# Closing and opening follow the edge of a shadow closely and take little time; a median does neither.
_COARSE_DIAMETERS = {'dark': 24.0, 'light': 24.0, 'any': 12.0}
# Noise makes closing and opening level off a slope of the light, which would shift the dots. A filter of this
# part of the window brings it back; where it changes the floor by more, there is an edge.
_SMOOTHING = 0.3
_EDGE = 0.02


def smooth_background(
    image: NDArray[np.uint8], polarity: str, largest_diameter: float
) -> NDArray[np.float32]:
    """Return the floor's luminance under and around the dots.

    Dots are replaced by what surrounds them: morphological closing takes out dark dots, opening light
    ones, a median both. All three keep the edge of a shadow where a low-pass filter would smear it.

    Args:
        image: shape (h, w, channels), slightly smoothed grey levels.
        polarity: ``dark``, ``light`` or ``any``.
        largest_diameter: diameter of the largest dot [px].

    Returns:
        array, shape (rows, columns, channels), for pixels as large as suffice, at least 1 grey level.
    """
    height, width, channels = image.shape
    factor = max(1, int(largest_diameter / _COARSE_DIAMETERS[polarity]))
    size = (-(-width // factor), -(-height // factor))
    coarse = cv2.resize(image, size, interpolation=cv2.INTER_AREA).reshape(size[1], size[0], channels)
    # An even window would shift the picture by a pixel.
    window = round((1.2 * largest_diameter + 2.0) / factor) | 1
    floor = np.maximum(_without_dots(coarse, polarity, window), 1).astype(np.float32)
    if polarity != 'any':
        floor = _without_plateaus(floor, round(_SMOOTHING * window) | 1)
    # Closing follows the noise up and opening down: the typical ratio takes that bias out again.
    step = 1 + len(coarse) // 80
    floor *= np.median(coarse[::step, ::step] / floor[::step, ::step], axis=(0, 1)).astype(np.float32)
    return np.maximum(floor, np.float32(1.0)).reshape(coarse.shape)


def _without_plateaus(floor: NDArray[np.float32], window: int) -> NDArray[np.float32]:
    # Two boxes are nearly a Gaussian, and take no longer the larger they are.
    smooth = cv2.blur(cv2.blur(floor, (window, window)), (window, window)).reshape(floor.shape)
    return np.asarray(np.where(np.abs(smooth - floor) <= _EDGE * floor, smooth, floor), dtype=np.float32)


def enlarged(background: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Return the background for each pixel of the image, shape (height, width, channels)."""
    fine = cv2.resize(background, (width, height), interpolation=cv2.INTER_LINEAR)
    return fine.reshape(height, width, background.shape[2])


def _without_dots(image: NDArray[np.uint8], polarity: str, window: int) -> NDArray[np.uint8]:
    if polarity == 'any':
        # Twice the dots' size: they must stay the minority in the window.
        filtered = cv2.medianBlur(image, 2 * window + 1)
    else:
        operation = cv2.MORPH_CLOSE if polarity == 'dark' else cv2.MORPH_OPEN
        # Without a frame the gradient over half a window would look like dots along the image border.
        frame = (window,) * 4
        framed = cv2.copyMakeBorder(image, *frame, cv2.BORDER_REPLICATE)
        filtered = cv2.morphologyEx(framed, operation, np.ones((window, window), np.uint8))
        filtered = filtered[window:-window, window:-window]
    return np.asarray(filtered, dtype=np.uint8).reshape(image.shape)
