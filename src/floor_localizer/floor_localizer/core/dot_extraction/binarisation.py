"""Binarisation (paper 3.1): contrast against the floor and a threshold that knows the noise."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.settings import DotDetectorSettings

# The sign of the difference that a dot makes, 0 for any difference.
_SIGNS = {'dark': -1.0, 'light': 1.0, 'any': 0.0}
_SAMPLES = 12_000
# A difference of 2 % from the floor is texture or dust, however little noise the camera has.
_SMALLEST_CONTRAST = 0.02


def contrast_image(
    image: NDArray[np.uint8], background: NDArray[np.float32], polarity: str
) -> NDArray[np.float32]:
    """Return the contrast of each pixel to the floor, relative to the floor's luminance, shape (h, w).

    Args:
        image: shape (h, w, channels), grey levels.
        background: shape (h, w, channels), grey levels of the floor.
        polarity: ``dark``, ``light``, or ``any`` for the root mean square over the channels.
    """
    return np.asarray(_contrasts(image, background, _SIGNS[polarity]), dtype=np.float32)


def contrast_threshold(
    image: NDArray[np.uint8], background: NDArray[np.float32], polarity: str, settings: DotDetectorSettings
) -> float:
    """Return the contrast above which a pixel belongs to a dot, relative to the floor's luminance.

    It lies above the floor's noise and texture, and at a part of the contrast that most dots have, so that
    the outline of a dot does not depend on the light.

    Args:
        image: shape (h, w, channels), slightly smoothed grey levels.
        background: shape (h, w, channels), grey levels of the floor.
        polarity: ``dark``, ``light``, or ``any``.
        settings: settings of dot extraction.
    """
    step = max(1, round((image.shape[0] * image.shape[1] / _SAMPLES) ** 0.5))
    sample = contrast_image(image[::step, ::step], background[::step, ::step], polarity).ravel()
    if polarity == 'any':
        spread = 1.4826 * np.median(sample)
        threshold = settings.noise_sigmas * spread
    else:
        # The lower half of the distribution holds no dots.
        ranks = [len(sample) * 16 // 100, len(sample) // 2]
        low, middle = np.partition(sample, ranks)[ranks]
        threshold = middle + settings.noise_sigmas * (middle - low)
    threshold = max(threshold, _SMALLEST_CONTRAST)
    of_dots = sample[sample > threshold]
    typical = np.quantile(of_dots, 0.75) if len(of_dots) else 0.0
    return float(max(threshold, settings.minimum_relative_contrast * typical))


def binarise(
    image: NDArray[np.uint8], background: NDArray[np.float32], polarity: str, threshold: float
) -> NDArray[np.uint8]:
    """Return the binary image, shape (h, w): 1 where the contrast lies above the threshold, else 0.

    Args:
        image: shape (h, w, channels), slightly smoothed grey levels.
        background: shape (h, w, channels), grey levels of the floor.
        polarity: ``dark``, ``light``, or ``any``.
        threshold: from :func:`contrast_threshold`.
    """
    sign = _SIGNS[polarity]
    if sign == 0.0:
        return np.asarray(_contrasts(image, background, sign) > threshold, dtype=np.uint8)
    return np.asarray(_binarise(image[..., 0], background[..., 0], sign, threshold), dtype=np.uint8)


@njit(cache=True)
def _contrasts(image, background, sign):  # type: ignore[no-untyped-def]
    height, width, channels = image.shape
    result = np.empty((height, width), np.float32)
    for v in range(height):
        for u in range(width):
            total = np.float32(0.0)
            for c in range(channels):
                difference = np.float32(image[v, u, c]) / background[v, u, c] - np.float32(1.0)
                total += difference * difference if sign == 0.0 else np.float32(sign) * difference
            total /= np.float32(channels)
            result[v, u] = np.sqrt(total) if sign == 0.0 else total
    return result


@njit(cache=True)
def _binarise(image, background, sign, threshold):  # type: ignore[no-untyped-def]
    # The comparison without a division, which takes most of the time in a large image.
    factor, level = np.float32(sign), np.float32(sign + threshold)
    height, width = image.shape
    result = np.empty((height, width), np.uint8)
    for v in range(height):
        for u in range(width):
            result[v, u] = factor * np.float32(image[v, u]) > level * background[v, u]
    return result
