"""Lamp candidates on the coarse grid.

A candidate is segmented at between a quarter and a half of its own peak, which removes the halo of bright lamps and
still finds dim ones. Thresholds increase by factors of two; each component is kept at the threshold that fits its peak.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.coarse_contrast import CELL
from vlc_beacon.core.lamp_image.settings import LampSettings

COMPONENTS_MAX = 20000
"""A threshold with more components shows texture, not lamps."""


def find_candidates(
    contrast: NDArray[np.uint8], lowest: float, settings: LampSettings
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return bounding boxes and peaks of candidates, brightest first.

    Args:
        contrast: contrast image, see `coarse_contrast`.
        lowest: minimum contrast of a lamp [grey levels].
        settings: lamp size limits.

    Returns:
        boxes, shape (n, 4): first column, first row, last column + 1, last row + 1 [px]; and peak contrasts, shape (n,)
        [grey levels].
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
    lamp = (sides.max(axis=1) <= settings.diameter_max + 2 * CELL) & (
        sides.max(axis=1) >= settings.diameter_min - CELL
    )
    order = np.argsort(-all_peaks[lamp], kind='stable')[: settings.lamps_max]
    return all_boxes[lamp][order], all_peaks[lamp][order]


def _components_at(
    contrast: NDArray[np.uint8], level: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
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
