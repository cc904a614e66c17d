"""Subpixel centroids, sizes and shapes of blobs, and the noise of the image, from which their accuracy follows."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Float32s, Floats, Ints, Pixels
from floor_localizer.core.dot_extraction.contrast import (
    contrast_along,
    contrast_direction,
    dot_level,
    ring_contrast_level,
)
from floor_localizer.core.dot_extraction.labelling import SURROUNDINGS_WIDTH, Boxes, Labels

# Pixels with less coverage are floor, with more are dot; pixels between are partly covered. This excludes noise and
# texture of the floor and of the dot's inside, and keeps the edge, which defines the centroid.
_FLOOR_COVERAGE = 0.15
_DOT_COVERAGE = 0.85
_MIDDLE_COVERAGE = 0.5
_SATURATED = 250
# Saturated pixels on a floor brighter than this are floor.
_SATURATED_FLOOR = 225.0
# Minimum number of ring pixels for an estimate of their noise.
_MIN_RING_PIXELS = 20
# Weight of ring noise in excess of the pixel noise: it is correlated between neighbours and averages out less.
_COMMON_NOISE_WEIGHT = 1.6

# Fraction of photon noise in the variance of a camera's noise; the rest is read-out noise and compression.
_PHOTON_NOISE_FRACTION = 0.7
# Tiles are a twelfth of the image, with a minimum width [px]; about 500 differences per tile suffice.
_SMALLEST_TILE = 48
_TILES_PER_SIDE = 12
_ROWS_PER_TILE = 12
_COLUMNS_PER_TILE = 48
_LAG = 2
# The lower 40 % of the differences are floor; dots, edges and texture are among the upper ones.
_QUANTILE = 0.4
_QUANTILE_OF_NORMAL = 0.5244

_COLUMNS = 12
_U, _V, _AREA, _NOISE, _UU, _UV, _VV, _CONTRAST, _STEP, _CLIPPED, _SOFTNESS, _EDGE_ASYMMETRY = range(_COLUMNS)


class Blobs(NamedTuple):
    """The n blobs of one image.

    Attributes:
        pixels: shape (n, 2), centroids u, v [px].
        noises: shape (n,), standard deviations of the centroids along each axis due to image noise [px].
        areas: shape (n,), areas, partly covered pixels weighted by their coverage [px^2].
        covariances: shape (n, 3), second moments uu, uv, vv of the outline [px^2].
        contrasts: shape (n,), contrast to the floor as a fraction of its luminance; 0 for an empty blob or one that is
            cut by the image border.
        steps: shape (n,), change of the floor's luminance over the blob, in the units of the contrast.
        clipped: shape (n,), saturated fraction of the blob and its soft edge (reflections).
        softness: shape (n,), area of the partly covered pixels over the area of the blob.
        edge_asymmetries: shape (n,), distance between the centroids of the outer and the inner half of the edge [px].
    """

    pixels: Floats
    noises: Floats
    areas: Floats
    covariances: Floats
    contrasts: Floats
    steps: Floats
    clipped: Floats
    softness: Floats
    edge_asymmetries: Floats

    @property
    def diameters(self) -> Floats:
        """Diameters of the discs of equal area, shape (n,) [px]."""
        return np.asarray(2.0 * np.sqrt(self.areas / np.pi))


def measure_blobs(image: Pixels, background: Float32s, mask: Pixels, labels: Labels, boxes: Boxes) -> Blobs:
    """Measure each blob in its surroundings.

    The weight of a pixel is its coverage by the dot: its contrast along the blob's colour, minus that of the ring, over
    the contrast of the blob's inside.

    Args:
        image: shape (h, w, channels), grey levels, not smoothed.
        background: shape (h, w, channels), grey levels of the floor.
        mask: shape (h, w), the binary image.
        labels: the blobs, grown by ``grow_labels``.
        boxes: bounding boxes of the blobs before growing.
    """
    noise = noise_at(image, (boxes[:, :2] + boxes[:, 2:4] - 1) // 2)
    table = _measure(image, background, mask, labels, boxes, noise, SURROUNDINGS_WIDTH)
    further = (table[:, column] for column in (_CONTRAST, _STEP, _CLIPPED, _SOFTNESS, _EDGE_ASYMMETRY))
    return Blobs(table[:, [_U, _V]], table[:, _NOISE], table[:, _AREA], table[:, _UU : _VV + 1], *further)


@njit(cache=True, error_model='numpy')
def _measure(
    image: Pixels, background: Float32s, mask: Pixels, labels: Labels, boxes: Boxes, noise: Floats, reach: int
) -> Floats:
    height, width = labels.shape
    table = np.zeros((len(boxes), _COLUMNS))
    for i in range(len(boxes)):
        left, top, right, bottom, area = boxes[i]
        if area == 0 or left == 0 or top == 0 or right == width or bottom == height:
            continue
        left, top, right, bottom = left - reach, top - reach, right + reach, bottom + reach
        left, top, right, bottom = max(0, left), max(0, top), min(width, right), min(height, bottom)
        indices, inside, ring = _blob_pixels(labels[top:bottom, left:right], mask, i + 1, left, top)
        direction = contrast_direction(image, background, indices[:inside])
        coverage = contrast_along(image, background, indices, direction)
        ring_contrast = contrast_along(image, background, ring, direction)
        floor = ring_contrast_level(ring_contrast)
        contrast = dot_level(coverage[:inside]) - floor
        if contrast <= 0.0:
            continue
        row = table[i]
        row[_CONTRAST] = contrast
        _centroid((coverage - floor) / contrast, indices, row)
        _shape(indices[:inside], row)
        light = background[(top + bottom) // 2, (left + right) // 2]
        deviation = _noise_sigma(ring_contrast - floor, noise[i] * np.sqrt(np.sum((direction / light) ** 2)))
        # Photon noise is proportional to the square root of the luminance, and the edge is half floor, half dot.
        brightness = 1.0 + 0.5 * contrast * np.mean(direction)
        row[_NOISE] *= (
            deviation / contrast * np.sqrt(1.0 - _PHOTON_NOISE_FRACTION + _PHOTON_NOISE_FRACTION * max(0.0, brightness))
        )
        row[_STEP] = _luminance_step(background, indices[:inside], direction)
        row[_CLIPPED] = _clipped_fraction(image, background, indices)
    return table


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
            noise[row, column] = max(_sigma_of_differences(counts), 12.0**-0.5)
    return noise


@njit(cache=True)
def _sigma_of_differences(counts: Ints) -> float:
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


@njit(cache=True, error_model='numpy')
def _noise_sigma(residuals: Floats, pixel_noise: float) -> float:
    # Effective standard deviation of a pixel around a blob, for the propagation to the centroid.
    if len(residuals) < _MIN_RING_PIXELS:
        return pixel_noise
    ring_noise = np.sqrt(np.mean(residuals**2))
    common = _COMMON_NOISE_WEIGHT**2 * max(0.0, ring_noise**2 - pixel_noise**2)
    return np.sqrt(min(ring_noise, pixel_noise) ** 2 + common)


@njit(cache=True, error_model='numpy')
def _blob_pixels(patch: Labels, mask: Pixels, label: int, left: int, top: int) -> tuple[Ints, int, Ints]:
    # Pixels (row, column) of a blob, followed by those of its soft edge; number of the former; pixels of its ring.
    indices, ring = np.empty((patch.size, 2), np.int64), np.empty((patch.size, 2), np.int64)
    inside = count = ring_count = 0
    for v in range(patch.shape[0]):
        for u in range(patch.shape[1]):
            if patch[v, u] == label:
                place = count
                if mask[top + v, left + u]:
                    indices[count] = indices[inside]
                    place = inside
                    inside += 1
                indices[place, 0], indices[place, 1] = top + v, left + u
                count += 1
            elif patch[v, u] == -label:
                ring[ring_count, 0], ring[ring_count, 1] = top + v, left + u
                ring_count += 1
    return indices[:count], inside, ring[:ring_count]


@njit(cache=True, error_model='numpy')
def _centroid(coverage: Floats, indices: Ints, row: Floats) -> None:
    u, v, area = _weighted_mean(coverage, indices, _FLOOR_COVERAGE, _DOT_COVERAGE)
    outer_u, outer_v, _ = _weighted_mean(coverage, indices, _FLOOR_COVERAGE, _MIDDLE_COVERAGE)
    inner_u, inner_v, _ = _weighted_mean(coverage, indices, _MIDDLE_COVERAGE, _DOT_COVERAGE)
    row[_U], row[_V], row[_AREA] = u, v, area
    row[_EDGE_ASYMMETRY] = np.hypot(outer_u - inner_u, outer_v - inner_v)
    # Propagation of unit noise of the coverage; pixels clipped to floor or dot do not contribute.
    total, count = 0.0, 0
    for k in range(len(indices)):
        if _FLOOR_COVERAGE < coverage[k] < _DOT_COVERAGE:
            total += 0.5 * ((indices[k, 1] - u) ** 2 + (indices[k, 0] - v) ** 2)
            count += 1
    row[_NOISE] = np.sqrt(total) / (area * (_DOT_COVERAGE - _FLOOR_COVERAGE))
    row[_SOFTNESS] = count / area


@njit(cache=True, error_model='numpy')
def _weighted_mean(coverage: Floats, indices: Ints, low: float, high: float) -> tuple[float, float, float]:
    # Centroid u, v and area, with coverages up to low as floor and from high on as dot.
    area = su = sv = 0.0
    for k in range(len(indices)):
        part = min(1.0, max(0.0, (coverage[k] - low) / (high - low)))
        area += part
        su += part * indices[k, 1]
        sv += part * indices[k, 0]
    return su / area, sv / area, area


@njit(cache=True, error_model='numpy')
def _shape(inside: Ints, row: Floats) -> None:
    mu = mv = muu = muv = mvv = 0.0
    for k in range(len(inside)):
        x, y = inside[k, 1] - row[_U], inside[k, 0] - row[_V]
        mu += x
        mv += y
        muu += x * x
        muv += x * y
        mvv += y * y
    n = len(inside)
    row[_UU] = muu / n - (mu / n) ** 2 + 1.0 / 12.0
    row[_UV] = muv / n - mu * mv / n**2
    row[_VV] = mvv / n - (mv / n) ** 2 + 1.0 / 12.0


@njit(cache=True, error_model='numpy')
def _clipped_fraction(image: Pixels, background: Float32s, indices: Ints) -> float:
    clipped = 0
    for k in range(len(indices)):
        v, u = indices[k, 0], indices[k, 1]
        for c in range(image.shape[2]):
            if image[v, u, c] >= _SATURATED and background[v, u, c] < _SATURATED_FLOOR:
                clipped += 1
                break
    return clipped / len(indices)


@njit(cache=True, error_model='numpy')
def _luminance_step(background: Float32s, inside: Ints, direction: Floats) -> float:
    # Contrast between the brightest and the darkest floor under the blob.
    darkest, brightest = np.inf, 0.0
    for k in range(len(inside)):
        brightness = 0.0
        for c in range(background.shape[2]):
            brightness += background[inside[k, 0], inside[k, 1], c]
        darkest, brightest = min(darkest, brightness), max(brightest, brightness)
    if np.sum(direction) > 0.0:
        return brightest / darkest - 1.0
    return 1.0 - darkest / brightest
