"""Binarisation (paper 3.1): polarity of the dots, smooth background, contrast to it, threshold from its noise."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit

from floor_localizer.core.arrays import Booleans, Float32s, Floats, Pixels
from floor_localizer.core.dot_extraction.contrast import relative_contrast
from floor_localizer.core.dot_extraction.labelling import label_blobs
from floor_localizer.core.settings import DotDetectorSettings

# Polarity. Minimum count of a second kind of chips, relative to the first; fewer are reflections and dust.
_SECOND_KIND = 0.4
_COLOUR_EXCESS = 1.3
_SATURATED = 250
# Minimum difference [grey levels]; on a dark floor, integer grey levels are coarse steps.
_ROUNDING = 4.0
_BLOB_CONTRAST_MIN = 0.05
_BLOB_NOISE_SIGMAS = 5.0
_COARSE_SIZE = 90.0
_SAMPLES_PER_SIDE = 16
# Scales of the Cauchy weights of a robust fit, from that of illumination changes down to that of chips [relative].
_OUTLIER_SCALES = (0.4, 0.24, 0.14, 0.08, 0.05)
# With a larger residual noise [relative] the view may contain an edge; then the local background is used if it yields
# more dots by this factor.
_UNEXPLAINED = 0.06
_CLEARLY_MORE = 1.5
_SHADOW_EDGE = 0.25
# Minimum area of a blob as a fraction of its bounding box; blobs below are the floor between chips.
_LEAST_FILLING = 0.4

# Background. It varies slowly, so it is computed in a coarser image, in which the largest dot has this diameter [px].
# Closing and opening preserve the edges of shadows and are fast; a median is neither.
_COARSE_DIAMETERS = {'dark': 24.0, 'light': 24.0, 'any': 12.0}
# With noise, closing and opening turn an illumination gradient into plateaus, which would shift the dots. A low-pass
# filter of this fraction of the window restores the gradient, except at edges, where it changes the floor by more.
_SMOOTHING = 0.3
_PLATEAU_EDGE = 0.02
SIGNS = {'dark': -1.0, 'light': 1.0, 'any': 0.0}  # sign of a dot's difference from the floor, 0 for any difference
# Threshold. Side of the tiles in which the noise of the floor is estimated [diameters of the largest dot].
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


class _BlobCounts(NamedTuple):
    """Numbers of blobs of a dot's size that are darker, lighter, or different in colour or brightness; and the noise of
    the floor [relative].
    """

    dark: int
    light: int
    coloured: int
    noise: float

    @property
    def dominant(self) -> int:
        """Number of blobs of the more frequent kind."""
        return max(self.dark, self.light)


def choose_polarity(image: Pixels, largest_diameter: float) -> str:
    """Return ``dark``, ``light`` or ``any``: the most frequent kind of blobs, independent of their size.

    The floor is the majority of the image, shape (h, w, channels), under slowly changing illumination. So a giant chip
    that fills a part of the view is still a chip, and the floor next to it is no light dot. If this model leaves large
    residuals, at the edge of a shadow or of a mat, a local background may yield more dots.
    """
    # Integer multiples of the coarse pixel: OpenCV averages them much faster.
    factor = max(1, round(max(image.shape) / _COARSE_SIZE))
    height, width, channels = image.shape[0] // factor, image.shape[1] // factor, image.shape[2]
    whole = image[: height * factor, : width * factor]
    coarse = cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA).reshape(height, width, channels)
    brightness = np.maximum(coarse.mean(axis=2, dtype=np.float32), np.float32(1.0))
    # Twice the dots' size, so that dots are a minority in the window.
    window = 2 * round(1.2 * largest_diameter / factor) + 1
    local = np.maximum(cv2.medianBlur(brightness.astype(np.uint8), window), 1)
    largest_area = 0.25 * np.pi * (largest_diameter / factor) ** 2
    # The rim of a reflection is bright, too.
    saturated = (coarse.max(axis=2) >= _SATURATED).astype(np.uint8)
    usable = cv2.dilate(saturated, np.ones((3, 3), np.uint8)) == 0
    counts = _count_kinds(coarse, brightness, _floor_brightness(local), usable, largest_area)
    if counts.noise > _UNEXPLAINED:
        # Along an edge a dot shifts the median, so that the floor next to it looks like a dot of the other kind.
        edge = cv2.morphologyEx(local, cv2.MORPH_GRADIENT, np.ones((window, window), np.uint8))
        usable &= edge < _SHADOW_EDGE * local
        second = _count_kinds(coarse, brightness, local.astype(np.float32), usable, largest_area)
        if second.dominant > _CLEARLY_MORE * counts.dominant:
            counts = second
    if min(counts.dark, counts.light) > _SECOND_KIND * counts.dominant:
        return 'any'
    if counts.coloured > _COLOUR_EXCESS * counts.dominant:
        return 'any'
    return 'dark' if counts.dark >= counts.light else 'light'


def _count_kinds(
    coarse: Pixels, brightness: Float32s, floor: Float32s, usable: Booleans, largest_area: float
) -> _BlobCounts:
    relative = brightness / floor - 1.0
    noise = 1.4826 * float(np.median(np.abs(relative)))
    threshold = np.maximum(max(_BLOB_CONTRAST_MIN, _BLOB_NOISE_SIGMAS * noise), _ROUNDING / floor)
    dark = _count_blobs((relative < -threshold) & usable, largest_area)
    light = _count_blobs((relative > threshold) & usable, largest_area)
    coloured = 0
    if coarse.shape[2] > 1:
        floor_colour = np.median(coarse[np.abs(relative) < threshold], axis=0)
        tint = coarse / (floor_colour / floor_colour.mean()).astype(np.float32) / floor[..., None] - 1.0
        coloured = _count_blobs((np.sqrt((tint**2).mean(axis=2)) > threshold) & usable, largest_area)
    return _BlobCounts(dark, light, coloured, noise)


@njit(cache=True, error_model='numpy')
def _floor_brightness(brightness: Pixels) -> Float32s:
    # Second-order polynomial of the logarithm, fitted to a sample of the pixels.
    height, width = brightness.shape
    v, u = np.linspace(-1.0, 1.0, height), np.linspace(-1.0, 1.0, width)
    step = max(1, -(-max(height, width) // _SAMPLES_PER_SIDE))
    sample = brightness[::step, ::step]
    design, levels = np.ones((sample.size, 5)), np.empty(sample.size)
    for row in range(sample.shape[0]):
        for column in range(sample.shape[1]):
            k = row * sample.shape[1] + column
            levels[k] = math.log(max(sample[row, column], 1))
            design[k, 1], design[k, 2] = u[column * step], v[row * step]
            design[k, 3], design[k, 4] = design[k, 1] ** 2, design[k, 2] ** 2
    solution: Floats = np.zeros(5)
    solution[0] = np.median(levels)
    for scale in _OUTLIER_SCALES:
        weights = 1.0 / (1.0 + ((levels - design @ solution) / scale) ** 2)
        weighted = design * weights.reshape(-1, 1)
        solution = np.linalg.solve(weighted.T @ design, weighted.T @ levels).astype(np.float64)
    across = solution[1] * u + solution[3] * u**2
    down = solution[0] + solution[2] * v + solution[4] * v**2
    return np.exp(down.reshape(-1, 1) + across).astype(np.float32)


def _count_blobs(mask: Booleans, largest_area: float) -> int:
    # Number of blobs of a dot's size that are completely in the image.
    height, width = mask.shape
    left, top, right, bottom, area = label_blobs(mask.astype(np.uint8))[1].T
    whole = (left > 0) & (top > 0) & (right < width) & (bottom < height)
    filled = area > _LEAST_FILLING * (right - left) * (bottom - top)
    return int(np.count_nonzero(whole & filled & (area <= largest_area)))


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
    return np.asarray(np.where(np.abs(smooth - floor) <= _PLATEAU_EDGE * floor, smooth, floor), dtype=np.float32)


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


def contrast_threshold(image: Pixels, background: Float32s, polarity: str, settings: DotDetectorSettings) -> Float32s:
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
    floor = _floor_thresholds(contrast, 1.0 / sampled_background.mean(axis=2), rows, columns, settings.noise_sigmas)
    np.maximum(floor, _SMALLEST_CONTRAST, out=floor)
    dot_contrasts = contrast[contrast > cv2.resize(floor, contrast.shape[::-1], interpolation=cv2.INTER_LINEAR)]
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
        return np.asarray(relative_contrast(image, upsample(background, width, height), sign) > fine, dtype=np.uint8)
    # Comparing grey levels is much faster than computing the contrast of each pixel.
    floor = background[..., 0]
    coarse = cv2.resize(threshold, floor.shape[::-1], interpolation=cv2.INTER_LINEAR)
    levels = np.clip(np.rint(floor * (1.0 + sign * coarse)), 0.0, 255.0).astype(np.uint8)
    levels = cv2.resize(levels, (width, height), interpolation=cv2.INTER_LINEAR)
    mask = cv2.compare(image[..., 0], levels, cv2.CMP_LT if sign < 0.0 else cv2.CMP_GT)
    return np.asarray(mask, dtype=np.uint8)


@njit(cache=True, error_model='numpy')
def _floor_thresholds(contrast: Float32s, rounding: Float32s, rows: int, columns: int, sigmas: float) -> Float32s:
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
