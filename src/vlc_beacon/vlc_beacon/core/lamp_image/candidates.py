"""Spots that may be lamps, on the coarse grid.

A spot is cut out at between a quarter and a half of its own peak, so a bright lamp loses its halo and a dim one is
found. Levels rise by factors of two and each spot is kept at the one level that suits its peak.
"""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from vlc_beacon.core.lamp_image.coarse_contrast import CELL
from vlc_beacon.core.lamp_image.settings import LampSettings

SPOTS_MAX = 20000
"""A level with more spots shows texture, not lamps."""


def candidate_spots(
    contrast: NDArray[np.uint8], lowest: float, settings: LampSettings
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return boxes and peaks of spots, the brightest first.

    Args:
        contrast: see `coarse_contrast`.
        lowest: contrast of the dimmest lamp [grey levels].
        settings: sizes that lamps have.

    Returns:
        shape (n, 4), first column, first row and the column and row after the last [px], and shape (n,), peak of the
        contrast [grey levels].
    """
    highest = int(contrast.max(initial=0))
    boxes, peaks = [np.empty((0, 4), np.int64)], [np.empty(0)]
    level, above = lowest, 0.0
    while level <= highest:
        found, peak = _spots_at(contrast, level)
        wanted = (peak >= above) & (peak < 4.0 * level)
        boxes.append(found[wanted])
        peaks.append(peak[wanted])
        level *= 2.0
        above = 2.0 * level
    all_boxes, all_peaks = np.concatenate(boxes), np.concatenate(peaks)
    sides = all_boxes[:, 2:] - all_boxes[:, :2]
    # A cell more: what a lamp covers in part counts.
    lamp = (sides.max(axis=1) <= settings.diameter_max + 2 * CELL) & (
        sides.max(axis=1) >= settings.diameter_min - CELL
    )
    order = np.argsort(-all_peaks[lamp], kind='stable')[: settings.lamps_max]
    return all_boxes[lamp][order], all_peaks[lamp][order]


def _spots_at(contrast: NDArray[np.uint8], level: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return boxes [px] and peaks of what reaches a level."""
    _, mask = cv2.threshold(contrast, level - 0.5, 255, cv2.THRESH_BINARY)
    # OpenCV's own statistics take ten times as long as the labels.
    count, labels = cv2.connectedComponents(mask, connectivity=8)
    if count > SPOTS_MAX:
        return np.empty((0, 4), np.int64), np.empty(0)
    boxes, peaks = _boxes_and_peaks(contrast, labels, count)
    return boxes[1:] * CELL, peaks[1:]


@njit(cache=True)
def _boxes_and_peaks(
    contrast: NDArray[np.uint8], labels: NDArray[np.int32], count: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return boxes, shape (count, 4) [cells], and peaks, shape (count,), of labels; those of label 0 mean nothing."""
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
