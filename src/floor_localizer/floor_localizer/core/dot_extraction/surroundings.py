"""The surroundings in which a blob is measured: its soft edge and a ring of floor."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.labelling import Boxes, Labels

_MARGIN = 2
_RING = 2
REACH = _MARGIN + _RING
"""How far the surroundings reach beyond the bounding box of a blob [px]."""

_NEIGHBOURS = np.array([(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)])


def grow_labels(labels: Labels, boxes: Boxes) -> None:
    """Let all blobs grow into the floor at the same speed, in place; the border of two runs half way.

    Args:
        labels: the blobs; afterwards the floor's pixels in a soft edge hold the label of their blob, those in
            a ring its negative.
        boxes: bounding boxes of the blobs, which stay as they are.
    """
    _grow(labels, boxes)


@njit(cache=True)
def _grow(labels: Labels, boxes: Boxes) -> None:
    height, width = labels.shape
    front = _outline(labels, boxes)
    for step in range(REACH):
        sign = 1 if step < _MARGIN else -1
        # Steps of four and of eight neighbours in turn grow an octagon, the nearest thing to a disc.
        neighbours = 4 if step % 2 == 0 else 8
        following = np.empty((neighbours * len(front), 2), np.int32)
        count = 0
        for i in range(len(front)):
            v, u = front[i, 0], front[i, 1]
            value = sign * abs(labels[v, u])
            for k in range(neighbours):
                y, x = v + _NEIGHBOURS[k, 0], u + _NEIGHBOURS[k, 1]
                if 0 <= y < height and 0 <= x < width and labels[y, x] == 0:
                    labels[y, x] = value
                    following[count, 0], following[count, 1] = y, x
                    count += 1
        front = following[:count]


@njit(cache=True)
def _outline(labels: Labels, boxes: Boxes) -> NDArray[np.int32]:
    height, width = labels.shape
    outline = np.empty((np.sum(boxes[:, 4]), 2), np.int32)
    count = 0
    for i in range(len(boxes)):
        for v in range(boxes[i, 1], boxes[i, 3]):
            for u in range(boxes[i, 0], boxes[i, 2]):
                if labels[v, u] != i + 1:
                    continue
                inside = 0 < u < width - 1 and 0 < v < height - 1
                if not inside or (
                    labels[v, u - 1] == 0
                    or labels[v, u + 1] == 0
                    or labels[v - 1, u] == 0
                    or labels[v + 1, u] == 0
                ):
                    outline[count, 0], outline[count, 1] = v, u
                    count += 1
    return outline[:count]
