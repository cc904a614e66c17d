"""Measure one lamp in the full-resolution image: background, shape and centroid.

The background is a plane fitted to the pixels around the lamp. The centroid is that of all brightness above this plane
within a disc centred on it. No threshold is applied, so noise does not bias it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray


@dataclass(frozen=True)
class LampBlobs:
    """Bright round blobs.

    Attributes:
        centroids: centroids (u, v), shape (n, 2) [px].
        sigmas: standard deviations of the centroids along u and v, shape (n, 2) [px].
        radii: half-maximum radii including blooming, shape (n,) [px].
        roundness: width over length, 1 for a disc, shape (n,).
        brightness: brightness above the background, shape (n,) [grey levels].
        backgrounds: brightness of the background, shape (n,) [grey levels].
    """

    centroids: NDArray[np.float64]
    sigmas: NDArray[np.float64]
    radii: NDArray[np.float64]
    roundness: NDArray[np.float64]
    brightness: NDArray[np.float64]
    backgrounds: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.centroids)


DISC_SCALE = 1.1
"""Radius of the centroid disc, which includes the blooming [lamp radii]."""
DISC_MARGIN = 1.5
"""Margin added to the radius of the centroid disc [px]."""
ITERATIONS_MAX = 6
CONVERGENCE_STEP = 1e-3
"""Centroid step that ends the iteration [px]."""
NOISE_FRACTION = 0.15
"""Noise over contrast above which the shape is measured on an image smoothed over 3 x 3 pixels."""
MEASURES = 13
U, V, SIGMA, RADIUS, ROUNDNESS, BRIGHTNESS, BACKGROUND, AREA = range(8)
PLANE, SLOPE_U, SLOPE_V, RING_MOMENT, UNEVENNESS = range(8, MEASURES)
SECTORS = 8


@njit(cache=True)
def measure_blob(
    image: NDArray[np.uint8],
    box: NDArray[np.int64],
    peak: float,
    noise: float,
    stripe_rows: int,
    limits: tuple[float, float, float],
) -> NDArray[np.float64]:
    """Return the measurements of a lamp, shape (MEASURES,); area 0 if there is no lamp within the limits.

    Args:
        image: grey image, shape (h, w).
        box: bounding box of the candidate, shape (4,) [px].
        peak: contrast of the candidate [grey levels].
        noise: standard deviation of a pixel [grey levels].
        stripe_rows: maximum height of a dark band in the lamp [px].
        limits: minimum and maximum diameter [px] and minimum roundness.
    """
    measures = np.zeros(MEASURES)
    side = max(box[2] - box[0], box[3] - box[1])
    margin = 4 + side // 2
    left, top = max(box[0] - margin, 0), max(box[1] - margin, 0)
    right, bottom = min(box[2] + margin, image.shape[1]), min(box[3] + margin, image.shape[0])
    level = _border_median(image, left, top, right, bottom)
    window = image[top:bottom, left:right]
    patch = _smooth(window) if noise > NOISE_FRACTION * peak else window.astype(np.float64)
    _measure_shape(patch - level, 0.5 * peak, stripe_rows, measures)
    measures[U] += left
    measures[V] += top
    measures[BACKGROUND] = measures[PLANE] = level
    # Most candidates of a lit ceiling end here: the rest takes ten times as long.
    if not (limits[0] <= 2.0 * measures[RADIUS] <= limits[1] and measures[ROUNDNESS] >= limits[2]):
        measures[AREA] = 0.0
    if measures[AREA] < 1.0:
        return measures
    extent = DISC_SCALE * measures[RADIUS] + DISC_MARGIN
    _fit_background(image, measures, extent, level + max(0.25 * peak, 3.0 * noise))
    _find_centroid(image, measures, extent, noise)
    return measures


@njit(cache=True)
def _border_median(image: NDArray[np.uint8], left: int, top: int, right: int, bottom: int) -> float:
    counts = np.zeros(256, np.int64)
    for column in range(left, right):
        counts[image[top, column]] += 1
        counts[image[bottom - 1, column]] += 1
    for row in range(top + 1, bottom - 1):
        counts[image[row, left]] += 1
        counts[image[row, right - 1]] += 1
    half, below = 0.5 * counts.sum(), 0
    for value in range(256):
        if below + counts[value] >= half:
            return value - 0.5 + (half - below) / max(counts[value], 1)
        below += counts[value]
    return 255.0


@njit(cache=True)
def _smooth(window: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return means over 3 x 3 pixels, clipped at the border."""
    height, width = window.shape
    smooth = np.empty((height, width))
    for v in range(height):
        for u in range(width):
            near = window[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2]
            smooth[v, u] = near.sum() / near.size
    return smooth


@njit(cache=True)
def _measure_shape(
    patch: NDArray[np.float64], threshold: float, stripe_rows: int, measures: NDArray[np.float64]
) -> None:
    """Set approximate centre, radius, roundness, area and brightness of the pixels above a threshold.

    Dark bands between two such pixels of a column belong to the lamp.
    """
    area, bright, light = 0.0, 0.0, 0.0
    sums = np.zeros(5)
    for u in range(patch.shape[1]):
        last = -1
        for v in range(patch.shape[0]):
            if patch[v, u] > threshold:
                bright += 1.0
                light += patch[v, u]
                first = last + 1 if last >= 0 and v - last <= stripe_rows + 1 else v
                for filled in range(first, v + 1):
                    area += 1.0
                    sums[0] += u
                    sums[1] += filled
                    sums[2] += u * u
                    sums[3] += filled * filled
                    sums[4] += u * filled
                last = v
    measures[AREA] = area
    if area < 1.0:
        return
    u, v = sums[0] / area, sums[1] / area
    # Add the variance of a square pixel.
    uu, vv, uv = sums[2] / area - u * u + 1 / 12, sums[3] / area - v * v + 1 / 12, sums[4] / area - u * v
    middle, extent = 0.5 * (uu + vv), math.sqrt(0.25 * (uu - vv) ** 2 + uv * uv)
    shortest, longest = max(middle - extent, 1e-9), middle + extent
    fill_fraction = area / (4.0 * math.pi * math.sqrt(shortest * longest))
    measures[U], measures[V] = u, v
    measures[RADIUS] = math.sqrt(area / math.pi)
    measures[ROUNDNESS] = math.sqrt(shortest / longest) * min(fill_fraction, 1.0)
    measures[BRIGHTNESS] = light / bright


@njit(cache=True)
def _fit_background(image: NDArray[np.uint8], measures: NDArray[np.float64], extent: float, brightest: float) -> None:
    """Set the background plane, fitted to the pixels around the lamp that are not bright."""
    outer = 1.5 * extent + 3.0
    normal, right_side = np.zeros((3, 3)), np.zeros(3)
    for v in range(max(int(measures[V] - outer), 0), min(int(measures[V] + outer) + 2, image.shape[0])):
        for u in range(max(int(measures[U] - outer), 0), min(int(measures[U] + outer) + 2, image.shape[1])):
            x, y = u - measures[U], v - measures[V]
            distance = math.sqrt(x * x + y * y)
            if extent < distance < outer and image[v, u] < brightest:
                row = (1.0, x, y)
                for i in range(3):
                    right_side[i] += row[i] * image[v, u]
                    for j in range(3):
                        normal[i, j] += row[i] * row[j]
    # With too few pixels on one side the tilt of the plane is undetermined.
    if normal[0, 0] > 2.0 * outer and np.linalg.det(normal / normal[0, 0]) > 1e-3:
        plane = np.linalg.solve(normal, right_side)
        measures[PLANE], measures[SLOPE_U], measures[SLOPE_V] = plane[0], plane[1], plane[2]
        measures[RING_MOMENT] = 0.5 * (normal[1, 1] + normal[2, 2])
        measures[UNEVENNESS] = _unevenness(image, measures, extent, outer, brightest)


@njit(cache=True)
def _unevenness(
    image: NDArray[np.uint8], measures: NDArray[np.float64], extent: float, outer: float, brightest: float
) -> float:
    """Return the RMS deviation of sectors around the lamp from the background plane [grey levels].

    Stains and tiles of a ceiling continue behind the lamp.
    """
    sums, squares, counts = np.zeros(SECTORS), np.zeros(SECTORS), np.zeros(SECTORS)
    for v in range(max(int(measures[V] - outer), 0), min(int(measures[V] + outer) + 2, image.shape[0])):
        for u in range(max(int(measures[U] - outer), 0), min(int(measures[U] + outer) + 2, image.shape[1])):
            x, y = u - measures[U], v - measures[V]
            if extent**2 < x * x + y * y < outer**2 and image[v, u] < brightest:
                plane = measures[PLANE] + measures[SLOPE_U] * x + measures[SLOPE_V] * y
                sector = int((math.atan2(y, x) / (2.0 * math.pi) + 0.5) * SECTORS) % SECTORS
                sums[sector] += image[v, u] - plane
                squares[sector] += (image[v, u] - plane) ** 2
                counts[sector] += 1.0
    total, sectors = 0.0, 0
    for k in range(SECTORS):
        if counts[k] > 3.0:
            mean = sums[k] / counts[k]
            # Subtract the variance of the mean due to noise.
            total += mean**2 - (squares[k] / counts[k] - mean**2) / counts[k]
            sectors += 1
    return math.sqrt(max(total / max(sectors, 1), 0.0))


@njit(cache=True)
def _find_centroid(image: NDArray[np.uint8], measures: NDArray[np.float64], extent: float, noise: float) -> None:
    """Set centroid and sigma."""
    u0, v0 = measures[U], measures[V]
    for _ in range(ITERATIONS_MAX):
        light, moment_u, moment_v, second_moment = 0.0, 0.0, 0.0, 0.0
        u_before, v_before = measures[U], measures[V]
        for v in range(max(math.ceil(v_before - extent), 0), min(int(v_before + extent) + 1, image.shape[0])):
            half_width = math.sqrt(max(extent**2 - (v - v_before) ** 2, 0.0))
            for u in range(
                max(math.ceil(u_before - half_width), 0), min(int(u_before + half_width) + 1, image.shape[1])
            ):
                above = image[v, u] - (measures[PLANE] + measures[SLOPE_U] * (u - u0) + measures[SLOPE_V] * (v - v0))
                light += above
                moment_u += above * (u - u_before)
                moment_v += above * (v - v_before)
                second_moment += (u - u_before) ** 2
        if light <= 0.0:
            measures[AREA] = 0.0
            return
        measures[U] = u_before + moment_u / light
        measures[V] = v_before + moment_v / light
        # Uncertainty of the slope of the background.
        slope = second_moment**2 / measures[RING_MOMENT] if measures[RING_MOMENT] > 0.0 else 0.0
        background_error = second_moment * measures[UNEVENNESS] / extent
        measures[SIGMA] = math.sqrt((second_moment + slope) * noise**2 + background_error**2) / light
        step = abs(measures[U] - u_before) + abs(measures[V] - v_before)
        if step < CONVERGENCE_STEP:
            break
        if step > extent:
            measures[AREA] = 0.0
            return
