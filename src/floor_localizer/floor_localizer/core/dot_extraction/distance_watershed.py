"""Segmentation of a binary shape: watershed of its distance transform."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Ints, Pixels
from floor_localizer.core.dot_extraction.labelling import find_root


@njit(cache=True, error_model='numpy')
def distance_watershed(
    raster: Pixels, thin: float, largest_waist: float, smallest_radius: float
) -> tuple[NDArray[np.int32], int]:
    """Split a binary shape at its waists, after removing thin parts.

    Thin parts, hairs that touch a dot, are removed by morphological opening with a disc of ``thin`` times the radius of
    the shape's largest disc. The distance transform of a convex shape has a single maximum. Pixels are flooded from the
    largest distance down (watershed); where the basins of two maxima meet, the shape has a waist of that radius. The
    shape is split there if the waist is narrow compared to the smaller maximum, else the basins are merged.

    Args:
        raster: shape (h, w), not zero inside the shape; its outer rows and columns are zero.
        thin: radius of the opening as a fraction of the largest radius.
        largest_waist: maximum ratio of a waist to the smaller maximum for a split.
        smallest_radius: minimum radius of a maximum with a basin of its own [px].

    Returns:
        basins, shape (h, w), 0 outside and 1, 2, … inside; and the number of basins.
    """
    distances = _squared_distances(raster)
    radius = thin * np.max(distances) ** 0.5
    away = _squared_distances((distances <= radius**2).astype(np.uint8))
    distances *= away <= radius**2
    return _flood(distances, largest_waist**2, smallest_radius**2)


@njit(cache=True, error_model='numpy')
def _squared_distances(raster: Pixels) -> NDArray[np.int32]:
    # Squared Euclidean distance of each pixel inside to the nearest one outside: an integer.
    height, width = raster.shape
    far = height + width
    rows = np.zeros((height, width), np.int32)
    for v in range(height):
        for u in range(width):
            rows[v, u] = (rows[v - 1, u] + 1 if v > 0 else far) if raster[v, u] else 0
    for v in range(height - 2, -1, -1):
        for u in range(width):
            rows[v, u] = min(rows[v, u], rows[v + 1, u] + 1)
    result = np.zeros((height, width), np.int32)
    for v in range(height):
        for u in range(width):
            best = rows[v, u] ** 2
            step = 1
            # Columns farther away than the best distance so far cannot contain a nearer pixel.
            while step * step < best and step < width:
                if u >= step:
                    best = min(best, step * step + rows[v, u - step] ** 2)
                if u + step < width:
                    best = min(best, step * step + rows[v, u + step] ** 2)
                step += 1
            result[v, u] = best
    return result


@njit(cache=True, error_model='numpy')
def _flood(distances: NDArray[np.int32], largest_waist: float, smallest_radius: float) -> tuple[NDArray[np.int32], int]:
    # All lengths are squared.
    height, width = distances.shape
    flat = distances.ravel()
    owner = np.full(flat.size, -1, np.int64)
    peaks, parents = np.empty(flat.size), np.empty(flat.size, np.int64)
    count = 0
    for pixel in _pixels_by_distance(flat):
        root, highest = int(np.int64(-1)), 0  # typed: numba would compile a second version for a plain int
        for step in (-1, 1, -width, width, -width - 1, -width + 1, width - 1, width + 1):
            if owner[pixel + step] < 0:
                continue
            other = find_root(parents, owner[pixel + step])
            if root >= 0 and root != other:
                high, low = (root, other) if peaks[root] >= peaks[other] else (other, root)
                if flat[pixel] > largest_waist * peaks[low] or peaks[low] < smallest_radius:
                    parents[low] = high
                    root, other = find_root(parents, root), high
            # A pixel joins the basin of its highest neighbour, so that no basin spreads along the flank of another.
            if flat[pixel + step] > highest:
                root, highest = other, flat[pixel + step]
        if root < 0:
            root = count
            peaks[count], parents[count] = flat[pixel], count
            count += 1
        owner[pixel] = root
    return _number_basins(owner, parents, height, width)


@njit(cache=True, error_model='numpy')
def _pixels_by_distance(values: NDArray[np.int32]) -> Ints:
    # Indices of the positive values, largest first (a counting sort).
    starts = np.zeros(np.max(values) + 2, np.int64)
    for value in values:
        starts[value] += 1
    starts[0] = 0
    for k in range(len(starts) - 2, -1, -1):
        starts[k] += starts[k + 1]
    pixels = np.empty(starts[0], np.int64)
    for pixel in range(len(values)):
        if values[pixel] > 0:
            pixels[starts[values[pixel] + 1]] = pixel
            starts[values[pixel] + 1] += 1
    return pixels


@njit(cache=True, error_model='numpy')
def _number_basins(owner: Ints, parents: Ints, height: int, width: int) -> tuple[NDArray[np.int32], int]:
    numbers = np.zeros(owner.size, np.int32)
    basins = np.zeros(owner.size, np.int32)
    count = 0
    for pixel in range(owner.size):
        if owner[pixel] >= 0:
            root = find_root(parents, owner[pixel])
            if numbers[root] == 0:
                count += 1
                numbers[root] = count
            basins[pixel] = numbers[root]
    return basins.reshape(height, width), count
