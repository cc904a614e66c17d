"""Labelling (paper 3.1): connected pixels become blobs."""

from __future__ import annotations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

Labels = NDArray[np.int32]
"""Image of labels, shape (h, w): 0 is the floor, blobs count from 1."""

DISCARDED = -(2**31)
"""Label of pixels that belong neither to the floor nor to a blob."""

Boxes = NDArray[np.int32]
"""Bounding boxes of blobs, shape (n, 5): left, top, right (exclusive), bottom (exclusive), area [px].

Row i belongs to label i + 1.
"""


def label_blobs(mask: NDArray[np.uint8]) -> tuple[Labels, Boxes]:
    """Number the connected blobs of a binary image, shape (h, w), not zero where a dot may be."""
    # Four neighbours: chips that touch in a corner stay apart.
    count, labels = cv2.connectedComponents(mask, connectivity=4, ltype=cv2.CV_32S)
    # OpenCV's own statistics take four times as long as the labelling itself.
    return np.asarray(labels, dtype=np.int32), bounding_boxes(np.asarray(labels, dtype=np.int32), count - 1)


def bounding_boxes(labels: Labels, count: int) -> Boxes:
    """Return the bounding boxes of the labels 1 to ``count``."""
    return np.asarray(_bounding_boxes(labels, count), dtype=np.int32)


@njit(cache=True)
def _bounding_boxes(labels: Labels, count: int) -> Boxes:
    height, width = labels.shape
    boxes = np.empty((count, 5), np.int32)
    boxes[:, 0], boxes[:, 1] = width, height
    boxes[:, 2:] = 0
    for v in range(height):
        for u in range(width):
            if labels[v, u] > 0:
                box = boxes[labels[v, u] - 1]
                box[0], box[1] = min(box[0], u), min(box[1], v)
                box[2], box[3] = max(box[2], u + 1), max(box[3], v + 1)
                box[4] += 1
    return boxes
