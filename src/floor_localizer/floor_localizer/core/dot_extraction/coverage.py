"""Coverage of the pixels around a blob by the dot, contrast of pixel over that of dot; and the noise of the image."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Float32s, Floats, Ints, Pixels

# Level of the floor: mean of the ring's inliers, within this number of standard deviations of the median. Median and
# deviation are from a sample; the deviation is the distance of the nearer sextile, as outliers are on one side.
_SAMPLE_SIZE = 25
_INLIER_DEVIATIONS = 3.0
# Level of the dot: mean of its upper quarter, because a small dot has few fully covered pixels.
_BINS = 64
_UPPER_FRACTION = 0.25
# Tiles are a twelfth of the image, with a minimum width [px]; about 500 differences per tile suffice.
_SMALLEST_TILE = 48
_TILES_PER_SIDE = 12
_ROWS_PER_TILE = 12
_COLUMNS_PER_TILE = 48
_LAG = 2
# The lower 40 % of the differences are floor; dots, edges and texture are among the upper ones.
_QUANTILE = 0.4
_QUANTILE_OF_NORMAL = 0.5244


@njit(cache=True, error_model='numpy')
def contrast_direction(image: Pixels, background: Float32s, indices: Ints) -> Floats:
    """Return the unit vector of the mean contrast to the floor of the pixels (row, column) of ``indices``, over the
    channels.
    """
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


def noise_at(image: Pixels, pixels: NDArray[np.integer]) -> Floats:
    """Return the standard deviation of the image noise around pixels (u, v), shape (n,), at least that of rounding.

    It is estimated from second differences of pixels two columns apart: they are zero for an illumination gradient and
    include correlated noise (demosaicing, compression, floor texture).
    """
    size = max(_SMALLEST_TILE, max(image.shape[:2]) // _TILES_PER_SIDE)
    tiles = _noise_tiles(image, size)
    return np.asarray(tiles[pixels[:, 1] // size, pixels[:, 0] // size], dtype=np.float64)


@njit(cache=True)
def _noise_tiles(image: Pixels, size: int) -> Floats:
    height, width, channels = image.shape
    rows, columns = (height + size - 1) // size, (width + size - 1) // size
    noise = np.empty((rows, columns))
    counts = np.zeros(2 * 255 + 1, np.int64)
    for row in range(rows):
        for column in range(columns):
            # The last tile of a row or column overlaps the previous one, to have the full size.
            top = max(0, min(row * size, height - size))
            left = max(0, min(column * size, width - size))
            counts[:] = 0
            for v in range(top, min(height, top + size), size // _ROWS_PER_TILE):
                for u in range(left, min(width, left + size) - 2 * _LAG, size // _COLUMNS_PER_TILE):
                    for c in range(channels):
                        sides = np.int64(image[v, u, c]) + np.int64(image[v, u + 2 * _LAG, c])
                        counts[abs(2 * np.int64(image[v, u + _LAG, c]) - sides)] += 1
            noise[row, column] = max(_noise_sigma(counts), 12.0**-0.5)
    return noise


@njit(cache=True)
def _noise_sigma(counts: Ints) -> float:
    # Differences are integers: bin k represents the interval k - 1/2 to k + 1/2.
    wanted = _QUANTILE * np.sum(counts)
    below = 0.0
    for k in range(len(counts)):
        if below + counts[k] >= wanted and counts[k] > 0:
            fraction = (wanted - below) / counts[k]
            quantile = 0.5 * fraction if k == 0 else k - 0.5 + fraction
            return quantile / (_QUANTILE_OF_NORMAL * np.sqrt(6.0))
        below += counts[k]
    return 0.0
