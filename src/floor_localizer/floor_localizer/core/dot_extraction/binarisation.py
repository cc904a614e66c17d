"""Smoothing and binarisation (paper 3.1): the floor's luminance, contrast to it, and a threshold from its noise."""

import cv2
import numpy as np
from numba import njit

from floor_localizer.core.arrays import Float32s, Pixels
from floor_localizer.core.settings import DotDetectorSettings

# The background varies slowly, so it is computed in a coarser image, in which the largest dot has this diameter [px].
# Closing and opening preserve the edges of shadows and are fast; a median is neither.
_COARSE_DIAMETERS = {'dark': 24.0, 'light': 24.0, 'any': 12.0}
# With noise, closing and opening turn an illumination gradient into plateaus, which would shift the dots. A low-pass
# filter of this fraction of the window restores the gradient, except at edges, where it changes the floor by more.
_SMOOTHING = 0.3
_EDGE = 0.02
SIGNS = {'dark': -1.0, 'light': 1.0, 'any': 0.0}
"""Sign of a dot's difference from the floor, 0 for any difference."""
# Side of the tiles in which the noise of the floor is estimated [diameters of the largest dot].
_TILE = 1.6
# Enough samples that neighbouring samples of a row are on the same area of floor, even between many chips.
_SAMPLES_PER_ROW = 20
_ROWS_PER_TILE = 10
# Fraction of the differences, the lower ones, that belong to the floor and not to dots; and the mean square of that
# fraction for normally distributed differences of variance 1.
_FLOOR_FRACTION = 0.8
_MEAN_SQUARE_OF_FLOOR_FRACTION = 0.438
# Maximum contrast of the bare floor, which is about 0 but may be raised by noise or colour [standard deviations].
_LARGEST_LEVEL = 2.5
# Minimum contrast of a dot: a difference of 2 % from the floor is texture or dust, independent of the camera's noise.
_SMALLEST_CONTRAST = 0.02


def smooth_background(image: Pixels, polarity: str, largest_diameter: float) -> Float32s:
    """Return the floor's luminance under and around the dots, at least 1, shape (rows, columns, channels), at low
    resolution.

    Dots are replaced by their surroundings: morphological closing removes dark dots, opening light ones, a median both.
    All three preserve the edges of shadows, which a low-pass filter would blur.

    Args:
        image: shape (h, w, channels), slightly smoothed grey levels.
        polarity: ``dark``, ``light`` or ``any``.
        largest_diameter: diameter of the largest dot [px].
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


def _smooth_plateaus(floor: Float32s, window: int) -> Float32s:
    # Two box filters approximate a Gaussian in constant time.
    smooth = cv2.blur(cv2.blur(floor, (window, window)), (window, window)).reshape(floor.shape)
    return np.asarray(np.where(np.abs(smooth - floor) <= _EDGE * floor, smooth, floor), dtype=np.float32)


def upsample(background: Float32s, width: int, height: int) -> Float32s:
    """Return the background in full resolution, shape (height, width, channels)."""
    fine = cv2.resize(background, (width, height), interpolation=cv2.INTER_LINEAR)
    return fine.reshape(height, width, background.shape[2])


def _remove_dots(image: Pixels, polarity: str, window: int) -> Pixels:
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


def contrast_threshold(
    image: Pixels, background: Float32s, polarity: str, settings: DotDetectorSettings
) -> Float32s:
    """Return the minimum contrast of a dot's pixels, for tiles of a slightly smoothed image, shape (rows, columns).

    It is above the noise and texture of the local floor, and a fraction of the typical contrast of dots, so that the
    outline of a dot does not depend on the illumination. ``background`` is that of `smooth_background`.
    """
    height, width = image.shape[:2]
    tile = _TILE * settings.largest_diameter(width, height)
    samples = np.ascontiguousarray(
        image[:: max(1, int(tile / _ROWS_PER_TILE)), :: max(1, int(tile / _SAMPLES_PER_ROW))]
    )
    sampled_background = upsample(background, samples.shape[1], samples.shape[0])
    contrast = relative_contrast(samples, sampled_background, SIGNS[polarity])
    rows, columns = max(1, round(height / tile)), max(1, round(width / tile))
    floor = _floor_thresholds(
        contrast, 1.0 / sampled_background.mean(axis=2), rows, columns, settings.noise_sigmas
    )
    np.maximum(floor, _SMALLEST_CONTRAST, out=floor)
    dot_contrasts = contrast[
        contrast > cv2.resize(floor, contrast.shape[::-1], interpolation=cv2.INTER_LINEAR)
    ]
    typical = _typical_contrast(dot_contrasts) if len(dot_contrasts) else 0.0
    return np.asarray(np.maximum(floor, settings.minimum_relative_contrast * typical), dtype=np.float32)


def _typical_contrast(contrasts_of_dots: Float32s) -> float:
    # Weighted median (weights: squares), robust to wet spots and shadows, which are large but have little contrast.
    contrasts_of_dots = np.sort(contrasts_of_dots)
    covered = np.cumsum(np.square(contrasts_of_dots))
    return float(contrasts_of_dots[np.searchsorted(covered, 0.5 * covered[-1])])


def binarise(image: Pixels, background: Float32s, polarity: str, threshold: Float32s) -> Pixels:
    """Return the binary image, shape (h, w): not 0 where the contrast is above the threshold, else 0.

    Image and background are those of `contrast_threshold`, which gives the threshold. For dark or light dots the
    thresholds are rounded to integer grey levels.
    """
    height, width = image.shape[:2]
    sign = SIGNS[polarity]
    if sign == 0.0:
        fine = cv2.resize(threshold, (width, height), interpolation=cv2.INTER_LINEAR)
        return np.asarray(
            relative_contrast(image, upsample(background, width, height), sign) > fine, dtype=np.uint8
        )
    # Comparing grey levels is much faster than computing the contrast of each pixel.
    floor = background[..., 0]
    coarse = cv2.resize(threshold, floor.shape[::-1], interpolation=cv2.INTER_LINEAR)
    levels = np.clip(np.rint(floor * (1.0 + sign * coarse)), 0.0, 255.0).astype(np.uint8)
    levels = cv2.resize(levels, (width, height), interpolation=cv2.INTER_LINEAR)
    mask = cv2.compare(image[..., 0], levels, cv2.CMP_LT if sign < 0.0 else cv2.CMP_GT)
    return np.asarray(mask, dtype=np.uint8)


@njit(cache=True, error_model='numpy')
def _floor_thresholds(
    contrast: Float32s, rounding: Float32s, rows: int, columns: int, sigmas: float
) -> Float32s:
    # The bare floor's contrast plus a number of standard deviations, for each of rows x columns tiles.
    height, width = contrast.shape
    thresholds = np.empty((rows, columns), np.float32)
    for row in range(rows):
        top, bottom = row * height // rows, (row + 1) * height // rows
        for column in range(columns):
            left, right = column * width // columns, (column + 1) * width // columns
            tile = contrast[top:bottom, left:right]
            # Differences between neighbours are hardly affected by an edge or a giant chip.
            squares = (0.5 * (tile[:, 1:] - tile[:, :-1]) ** 2).ravel()
            count = max(1, int(_FLOOR_FRACTION * len(squares)))
            variance = np.mean(np.partition(squares, count - 1)[:count]) / _MEAN_SQUARE_OF_FLOOR_FRACTION
            variance += np.mean(rounding[top:bottom, left:right]) ** 2 / 12.0
            deviation = np.sqrt(variance)
            level = np.median(tile)
            thresholds[row, column] = min(max(level, 0.0), _LARGEST_LEVEL * deviation) + sigmas * deviation
    return thresholds


@njit(cache=True, error_model='numpy')
def relative_contrast(image: Pixels, background: Float32s, sign: float) -> Float32s:
    """Return the contrast of each pixel to the floor as a fraction of the floor's luminance, shape (h, w).

    Image and background have the same shape, (h, w, channels). The sign is 1 for light dots, -1 for dark ones, and 0
    for the root mean square over the channels.
    """
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
