"""Background luminance smoothing (paper 3.1): the luminance of the floor without dots."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

# The background varies slowly, so it is computed in a coarser image, in which the largest dot has this diameter [px].
# Closing and opening preserve the edges of shadows and are fast; a median is neither.
_COARSE_DIAMETERS = {'dark': 24.0, 'light': 24.0, 'any': 12.0}
# With noise, closing and opening turn an illumination gradient into plateaus, which would shift the dots. A low-pass
# filter of this fraction of the window restores the gradient, except at edges, where it changes the floor by more.
_SMOOTHING = 0.3
_EDGE = 0.02


def smooth_background(
    image: NDArray[np.uint8], polarity: str, largest_diameter: float
) -> NDArray[np.float32]:
    """Return the floor's luminance under and around the dots.

    Dots are replaced by their surroundings: morphological closing removes dark dots, opening light ones, a median both.
    All three preserve the edges of shadows, which a low-pass filter would blur.

    Args:
        image: shape (h, w, channels), slightly smoothed grey levels.
        polarity: ``dark``, ``light`` or ``any``.
        largest_diameter: diameter of the largest dot [px].

    Returns:
        shape (rows, columns, channels), grey levels in reduced resolution, at least 1.
    """
    height, width, channels = image.shape
    factor = max(1, int(largest_diameter / _COARSE_DIAMETERS[polarity]))
    size = (-(-width // factor), -(-height // factor))
    coarse = cv2.resize(image, size, interpolation=cv2.INTER_AREA).reshape(size[1], size[0], channels)
    # An even window would shift the image by half a pixel.
    window = round((1.2 * largest_diameter + 2.0) / factor) | 1
    floor = np.maximum(_remove_dots(coarse, polarity, window), 1).astype(np.float32)
    if polarity != 'any':
        floor = _smooth_plateaus(floor, round(_SMOOTHING * window) | 1)
    # With noise, closing is biased up and opening down: divide by the median ratio.
    step = 1 + len(coarse) // 80
    floor *= np.median(coarse[::step, ::step] / floor[::step, ::step], axis=(0, 1)).astype(np.float32)
    return np.maximum(floor, np.float32(1.0)).reshape(coarse.shape)


def _smooth_plateaus(floor: NDArray[np.float32], window: int) -> NDArray[np.float32]:
    # Two box filters approximate a Gaussian in constant time.
    smooth = cv2.blur(cv2.blur(floor, (window, window)), (window, window)).reshape(floor.shape)
    return np.asarray(np.where(np.abs(smooth - floor) <= _EDGE * floor, smooth, floor), dtype=np.float32)


def upsample(background: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """Return the background in full resolution, shape (height, width, channels)."""
    fine = cv2.resize(background, (width, height), interpolation=cv2.INTER_LINEAR)
    return fine.reshape(height, width, background.shape[2])


def _remove_dots(image: NDArray[np.uint8], polarity: str, window: int) -> NDArray[np.uint8]:
    if polarity == 'any':
        # Twice the dots' size, so that dots are a minority in the window.
        filtered = cv2.medianBlur(image, 2 * window + 1)
    else:
        operation = cv2.MORPH_CLOSE if polarity == 'dark' else cv2.MORPH_OPEN
        # Without padding, the gradient over half a window would be detected as dots along the image border.
        border = (window,) * 4
        bordered = cv2.copyMakeBorder(image, *border, cv2.BORDER_REPLICATE)
        filtered = cv2.morphologyEx(bordered, operation, np.ones((window, window), np.uint8))
        filtered = filtered[window:-window, window:-window]
    return np.asarray(filtered, dtype=np.uint8).reshape(image.shape)
