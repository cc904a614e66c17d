"""Contrast of pixels to the floor: of each pixel, of the ring around a blob and of a dot."""

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Float32s, Floats, Ints, Pixels

# Level of the floor: mean of the ring's inliers, within this number of standard deviations of the median. Median and
# deviation are from a sample; the deviation is the distance of the nearer sextile, as outliers are on one side.
_SAMPLE_SIZE = 25
_INLIER_DEVIATIONS = 3.0
# Level of the dot: mean of its upper quarter, because a small dot has few fully covered pixels.
_BINS = 64
_UPPER_FRACTION = 0.25


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


@njit(cache=True, error_model='numpy')
def contrast_direction(image: Pixels, background: Float32s, indices: Ints) -> Floats:
    """Return the unit vector, over the channels, of the mean contrast of the pixels (row, column) of ``indices``."""
    direction = np.zeros(image.shape[2])
    for k in range(len(indices)):
        v, u = indices[k, 0], indices[k, 1]
        for c in range(image.shape[2]):
            direction[c] += image[v, u, c] / background[v, u, c] - 1.0
    return direction / max(np.sqrt(np.sum(direction**2)), 1e-12)


@njit(cache=True, error_model='numpy')
def contrast_along(image: Pixels, background: Float32s, indices: Ints, direction: Floats) -> Floats:
    """Return the contrasts of pixels to the floor along a direction, as fractions of the floor, shape (n,)."""
    result = np.zeros(len(indices))
    for k in range(len(indices)):
        v, u = indices[k, 0], indices[k, 1]
        for c in range(image.shape[2]):
            result[k] += direction[c] * (image[v, u, c] / background[v, u, c] - 1.0)
    return result


@njit(cache=True, error_model='numpy')
def ring_contrast_level(ring: Floats) -> float:
    """Return the mean of a ring's contrasts, shape (n,), without outliers; 0 without a ring."""
    if len(ring) == 0:
        return 0.0
    sample = _sorted_sample(ring)
    middle = sample[len(sample) // 2]
    below, above = middle - sample[len(sample) // 6], sample[(5 * len(sample)) // 6] - middle
    limit = _INLIER_DEVIATIONS * min(below, above)
    total, count = 0.0, 0
    for value in ring:
        if abs(value - middle) <= limit:
            total += value
            count += 1
    return total / count


@njit(cache=True, error_model='numpy')
def _sorted_sample(values: Floats) -> Floats:
    step = -(-len(values) // _SAMPLE_SIZE)
    sample = values[::step].copy()
    for k in range(1, len(sample)):
        value, place = sample[k], k
        while place > 0 and sample[place - 1] > value:
            sample[place] = sample[place - 1]
            place -= 1
        sample[place] = value
    return sample


@njit(cache=True, error_model='numpy')
def dot_level(inside: Floats) -> float:
    """Return the mean of the upper quarter of the contrasts of a blob's pixels, shape (n,)."""
    top = np.max(inside)
    if top <= 0.0:
        return 0.0
    counts, sums = np.zeros(_BINS, np.int64), np.zeros(_BINS)
    for value in inside:
        place = min(_BINS - 1, int(max(0.0, value) / top * _BINS))
        counts[place] += 1
        sums[place] += value
    wanted = max(1.0, _UPPER_FRACTION * len(inside))
    count, total = 0.0, 0.0
    for place in range(_BINS - 1, -1, -1):
        if counts[place] > 0:
            fraction = min(1.0, (wanted - count) / counts[place])
            count += fraction * counts[place]
            total += fraction * sums[place]
        if count >= wanted:
            break
    return total / count
