"""Detects lamps in a grey image: coarse contrast, candidates, then measurements at full resolution.

A candidate is segmented at between a quarter and a half of its own peak, which removes the halo of bright lamps and
still finds dim ones. Thresholds increase by factors of two; each component is kept at the threshold that fits its peak.
"""

import math

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image import blob_measurement as blob
from vlc_beacon.core.lamp_image.blob_measurement import LampBlobs
from vlc_beacon.core.lamp_image.striped_disc import fit_striped_disc
from vlc_beacon.core.settings import LampSettings
from vlc_beacon.core.vlc_beacon_error import LampImageError

CELL = 4
"""Side length of a cell [px]."""
BACKGROUND_CELLS = 4
"""Side length of a cell of the background image [cells]."""
NOISE_ROWS = 32
_NORMAL_MAD = 0.6745
NOISE_MIN = 0.3
"""Quantization noise [grey levels]."""


def coarse_contrast(
    image: NDArray[np.uint8], diameter_max: float, stripe_rows: float
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return contrast and background, both of shape (h // CELL, w // CELL) [grey levels].

    The background is a morphological opening with a kernel larger than a lamp. Before it, a closing along the columns
    fills the dark bands of a rolling shutter.

    Args:
        image: grey image, shape (h, w).
        diameter_max: maximum lamp diameter [px].
        stripe_rows: maximum height of a dark band in a lamp [px], 0 for none.
    """
    height, width = image.shape
    size = width // CELL, height // CELL
    coarse = cv2.resize(image[: size[1] * CELL, : size[0] * CELL], size, interpolation=cv2.INTER_AREA)
    if stripe_rows > 0.0:
        column = np.ones((1 + math.ceil(stripe_rows / CELL), 1), np.uint8)
        coarse = cv2.morphologyEx(coarse, cv2.MORPH_CLOSE, column)
    downsampled = cv2.resize(
        coarse, (max(size[0] // BACKGROUND_CELLS, 1), max(size[1] // BACKGROUND_CELLS, 1)), interpolation=cv2.INTER_AREA
    )
    side = 1 + 2 * math.ceil(0.5 * diameter_max / (CELL * BACKGROUND_CELLS) + 1.0)
    # Limit the kernel to the size of the image.
    kernel = np.ones((min(side, 2 * downsampled.shape[0] - 1), min(side, 2 * downsampled.shape[1] - 1)), np.uint8)
    opened = cv2.morphologyEx(downsampled, cv2.MORPH_OPEN, kernel)
    background = cv2.resize(opened, size, interpolation=cv2.INTER_LINEAR)
    return cv2.subtract(coarse, background), background


def noise_sigma(image: NDArray[np.uint8]) -> float:
    """Estimate the noise standard deviation of a pixel [grey levels] from second differences along rows."""
    step = max(image.shape[0] // NOISE_ROWS, 1)
    rows = image[step // 2 :: step].astype(np.int16)
    differences = rows[:, :-2] - 2 * rows[:, 1:-1] + rows[:, 2:]
    # The median of integers is coarse; the mean square of the small differences is not.
    magnitude = np.abs(differences)
    typical = float(np.median(magnitude))
    low = magnitude[magnitude <= 3.0 * typical + 1.0]
    spread = math.sqrt(float(np.mean(low.astype(np.float64) ** 2))) if len(low) else 0.0
    return max(max(spread, typical / _NORMAL_MAD) / math.sqrt(6.0), NOISE_MIN)


COMPONENTS_MAX = 20000
"""A threshold with more components shows texture, not lamps."""


def find_candidates(
    contrast: NDArray[np.uint8], lowest: float, settings: LampSettings
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return boxes and peak contrasts of candidates, brightest first.

    Args:
        contrast: contrast image, see `coarse_contrast`.
        lowest: minimum contrast of a lamp [grey levels].
        settings: lamp size limits.

    Returns:
        boxes, shape (n, 4): first column, first row, last column + 1, last row + 1 [px]; and peaks, shape (n,).
    """
    highest = int(contrast.max(initial=0))
    boxes, peaks = [np.empty((0, 4), np.int64)], [np.empty(0)]
    level, above = lowest, 0.0
    while level <= highest:
        found, peak = _components_at(contrast, level)
        selected = (peak >= above) & (peak < 4.0 * level)
        boxes.append(found[selected])
        peaks.append(peak[selected])
        level *= 2.0
        above = 2.0 * level
    all_boxes, all_peaks = np.concatenate(boxes), np.concatenate(peaks)
    sides = all_boxes[:, 2:] - all_boxes[:, :2]
    # One cell of tolerance for partly covered cells.
    lamp = (sides.max(axis=1) <= settings.diameter_max + 2 * CELL) & (sides.max(axis=1) >= settings.diameter_min - CELL)
    order = np.argsort(-all_peaks[lamp], kind='stable')[: settings.lamps_max]
    return all_boxes[lamp][order], all_peaks[lamp][order]


def _components_at(contrast: NDArray[np.uint8], level: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return boxes [px] and peaks of the connected components above a threshold."""
    _, mask = cv2.threshold(contrast, level - 0.5, 255, cv2.THRESH_BINARY)
    # connectedComponentsWithStats takes ten times as long.
    count, labels = cv2.connectedComponents(mask, connectivity=8)
    if count > COMPONENTS_MAX:
        return np.empty((0, 4), np.int64), np.empty(0)
    boxes, peaks = _boxes_and_peaks(contrast, labels, count)
    return boxes[1:] * CELL, peaks[1:]


@njit(cache=True)
def _boxes_and_peaks(
    contrast: NDArray[np.uint8], labels: NDArray[np.int32], count: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return boxes, shape (count, 4) [cells], and peaks, shape (count,), of labels; label 0 is not set."""
    boxes, peaks = np.zeros((count, 4), np.int64), np.zeros(count)
    boxes[:, :2] = max(labels.shape)
    for row in range(labels.shape[0]):
        for column in range(labels.shape[1]):
            label = labels[row, column]
            if label > 0:
                peaks[label] = max(peaks[label], contrast[row, column])
                boxes[label, 0] = min(boxes[label, 0], column)
                boxes[label, 1] = min(boxes[label, 1], row)
                boxes[label, 2] = max(boxes[label, 2], column + 1)
                boxes[label, 3] = max(boxes[label, 3], row + 1)
    return boxes, peaks


SIGMA_MIN = 0.02
"""Lower bound of the centroid standard deviation, due to pixel non-uniformity [px]."""
SIDE_MIN = 16
"""Minimum image side [px]."""
DUPLICATE_RADIUS_FRACTION = 0.5
"""Blobs whose centres are closer than this fraction of a radius are duplicates."""


class LampDetector:
    """Lamp detector."""

    def __init__(self, settings: LampSettings | None = None) -> None:
        """Set the lamp settings; None for the defaults."""
        self._settings = settings or LampSettings()

    def detect(self, image: NDArray[np.uint8]) -> LampBlobs:
        """Return the lamps of a grey image, shape (h, w), brightest first; raises `LampImageError` for others."""
        _check(image)
        settings = self._settings
        contrast, _ = coarse_contrast(image, settings.diameter_max, settings.stripe_rows)
        noise = noise_sigma(image)
        lowest = max(settings.contrast_min, settings.noise_sigmas * noise / CELL)
        boxes, peaks = find_candidates(contrast, lowest, settings)
        stripe_rows = round(settings.stripe_rows)
        limits = settings.diameter_min, settings.diameter_max, settings.roundness_min
        found: list[NDArray[np.float64]] = []
        for box, peak in zip(boxes, peaks, strict=True):
            measures = blob.measure_blob(image, box, peak, noise, stripe_rows, limits)
            if (
                measures[blob.AREA] > 0.0
                and _is_whole(measures, image.shape)
                and not any(_are_duplicates(measures, other) for other in found)
            ):
                found.append(measures)
        blobs = _blobs(np.array(found).reshape(-1, blob.MEASURES))
        return fit_striped_disc(image, blobs, noise) if stripe_rows > 0 else blobs


def _check(image: NDArray[np.uint8]) -> None:
    if image.dtype != np.uint8 or image.ndim != 2:
        raise LampImageError(
            f'the image has type {image.dtype} and {image.ndim} dimensions; give a grey image of type uint8'
        )
    if min(image.shape) < SIDE_MIN:
        height, width = image.shape
        raise LampImageError(f'the image has {width} x {height} pixels; give one of {SIDE_MIN} x {SIDE_MIN} or more')


def _is_whole(measures: NDArray[np.float64], shape: tuple[int, ...]) -> bool:
    u, v, radius = measures[[blob.U, blob.V, blob.RADIUS]]
    return bool(radius <= u <= shape[1] - 1 - radius and radius <= v <= shape[0] - 1 - radius)


def _are_duplicates(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    distance = np.hypot(a[blob.U] - b[blob.U], a[blob.V] - b[blob.V])
    return bool(distance < DUPLICATE_RADIUS_FRACTION * max(a[blob.RADIUS], b[blob.RADIUS]))


def _blobs(measures: NDArray[np.float64]) -> LampBlobs:
    centroids, radii = measures[:, [blob.U, blob.V]], measures[:, blob.RADIUS]
    sigma = np.hypot(measures[:, blob.SIGMA], SIGMA_MIN)
    return LampBlobs(
        centroids,
        np.column_stack([sigma, sigma]),
        radii,
        measures[:, blob.ROUNDNESS],
        measures[:, blob.BRIGHTNESS],
        measures[:, blob.BACKGROUND],
    )
