"""Noise of the camera and texture of the floor, estimated from the image itself."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Tiles are a twelfth of the image, with a minimum width [px]; about 500 differences per tile suffice.
_SMALLEST_TILE = 48
_TILES_PER_SIDE = 12
_ROWS_PER_TILE = 12
_COLUMNS_PER_TILE = 48
_LAG = 2
# The lower 40 % of the differences are floor; dots, edges and texture are among the upper ones.
_QUANTILE = 0.4
_QUANTILE_OF_NORMAL = 0.5244


def noise_at(image: NDArray[np.uint8], pixels: NDArray[np.integer]) -> NDArray[np.float64]:
    """Return the standard deviation of the image noise around each of some pixels.

    It is estimated from second differences of pixels two columns apart: they are zero for an illumination gradient and
    include correlated noise (demosaicing, compression, floor texture).

    Args:
        image: shape (h, w, channels), grey levels, not smoothed.
        pixels: shape (n, 2), u and v [px].

    Returns:
        shape (n,) [grey levels]; at least the quantization noise of integer levels.
    """
    size = max(_SMALLEST_TILE, max(image.shape[:2]) // _TILES_PER_SIDE)
    tiles = _noise_tiles(image, size)
    return np.asarray(tiles[pixels[:, 1] // size, pixels[:, 0] // size], dtype=np.float64)


@njit(cache=True)
def _noise_tiles(image: NDArray[np.uint8], size: int) -> NDArray[np.float64]:
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
def _noise_sigma(counts: NDArray[np.int64]) -> float:
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
