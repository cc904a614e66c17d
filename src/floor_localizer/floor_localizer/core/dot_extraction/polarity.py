"""Polarity of a floor's dots: darker than the floor, lighter, or any colour."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit

from floor_localizer.core.arrays import Booleans, Float32s, Floats, Pixels
from floor_localizer.core.dot_extraction.labelling import label_blobs

# Minimum count of a second kind of chips, relative to the first; fewer are reflections and dust.
_SECOND_KIND = 0.4
_COLOUR_EXCESS = 1.3
_SATURATED = 250
# Minimum difference [grey levels]; on a dark floor, integer grey levels are coarse steps.
_ROUNDING = 4.0
_SMALLEST_CONTRAST = 0.05
_NOISE_SIGMAS = 5.0
_COARSE_SIZE = 90.0
_SAMPLES_PER_SIDE = 16
# Scales of the Cauchy weights of a robust fit, from that of illumination changes down to that of chips [relative].
_OUTLIER_SCALES = (0.4, 0.24, 0.14, 0.08, 0.05)
# With a larger residual noise [relative] the view may contain an edge; then the local background is used if it yields
# more dots by this factor.
_UNEXPLAINED = 0.06
_CLEARLY_MORE = 1.5
_EDGE = 0.25
# Minimum area of a blob as a fraction of its bounding box; blobs below are the floor between chips.
_LEAST_FILLING = 0.4


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
        usable &= edge < _EDGE * local
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
    threshold = np.maximum(max(_SMALLEST_CONTRAST, _NOISE_SIGMAS * noise), _ROUNDING / floor)
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
