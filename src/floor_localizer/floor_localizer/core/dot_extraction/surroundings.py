"""The surroundings used to measure a blob: its soft edge and a ring of floor."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.labelling import Boxes, Labels

_MARGIN = 2
_RING = 2
SURROUNDINGS_WIDTH = _MARGIN + _RING
"""Width of the surroundings outside the bounding box of a blob [px]."""


def grow_labels(labels: Labels, boxes: Boxes) -> None:
    """Grow all blobs into the floor simultaneously, in place; the border between two blobs is halfway.

    Args:
        labels: the blobs; afterwards, floor pixels in a soft edge have the label of their blob, those in a ring its
            negative.
        boxes: bounding boxes of the blobs, not modified.
    """
    _grow(labels, boxes)


@njit(cache=True)
def _grow(labels: Labels, boxes: Boxes) -> None:
    width = labels.shape[1]
    flat = labels.reshape(-1)
    front = _outline(labels, boxes)
    # Alternating steps with 4 and 8 neighbours grow an octagon, an approximate disc.
    offsets = np.array([1, width, -1, -width, width + 1, width - 1, 1 - width, -width - 1])
    for step in range(SURROUNDINGS_WIDTH):
        sign = 1 if step < _MARGIN else -1
        neighbours = 4 if step % 2 == 0 else 8
        next_front = np.empty(neighbours * len(front), np.int64)
        count = 0
        for place in front:
            # Skip the image border, where a step could leave the image and nothing is measured.
            if not (0 < place % width < width - 1 and width <= place < len(flat) - width):
                continue
            value = sign * abs(flat[place])
            for k in range(neighbours):
                if flat[place + offsets[k]] == 0:
                    flat[place + offsets[k]] = value
                    next_front[count] = place + offsets[k]
                    count += 1
        front = next_front[:count]


@njit(cache=True)
def _outline(labels: Labels, boxes: Boxes) -> NDArray[np.int64]:
    height, width = labels.shape
    outline = np.empty(np.sum(boxes[:, 4]), np.int64)
    count = 0
    for i in range(len(boxes)):
        left, top, right, bottom = max(1, boxes[i, 0]), max(1, boxes[i, 1]), boxes[i, 2], boxes[i, 3]
        for v in range(top, min(bottom, height - 1)):
            for u in range(left, min(right, width - 1)):
                if labels[v, u] == i + 1 and (
                    labels[v, u - 1] == 0
                    or labels[v, u + 1] == 0
                    or labels[v - 1, u] == 0
                    or labels[v + 1, u] == 0
                ):
                    outline[count] = v * width + u
                    count += 1
    return outline[:count]
