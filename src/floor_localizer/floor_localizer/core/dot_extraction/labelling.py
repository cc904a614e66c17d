"""Labelling (paper 3.1): connected components of the binary image, and their surroundings."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from floor_localizer.core.arrays import Ints, Pixels

Labels = NDArray[np.int32]  # label image, shape (h, w): 0 is the floor, blobs are numbered from 1
DISCARDED = -(2**31)  # label of pixels that are neither floor nor blob
Boxes = NDArray[np.int32]
"""Bounding boxes of blobs, shape (n, 5): left, top, right (exclusive), bottom (exclusive), area [px].

Row i belongs to label i + 1.
"""

_PIXELS_PER_CHUNK = 8
_MARGIN = 2
_RING = 2
SURROUNDINGS_WIDTH = _MARGIN + _RING  # width of the surroundings outside the bounding box of a blob [px]


def label_blobs(mask: Pixels, smallest_area: float = 0.0) -> tuple[Labels, Boxes]:
    """Label the connected blobs of a binary image, shape (h, w), by 4-connectivity: chips that touch at a corner are
    two.

    Blobs of less than the smallest area [px] are labelled as floor.
    """
    height, width = mask.shape
    # Most of an image is floor, which is skipped in chunks of 8 pixels; each padded row ends with a zero.
    padded = np.zeros((height, (width // _PIXELS_PER_CHUNK + 1) * _PIXELS_PER_CHUNK), np.uint8)
    padded[:, :width] = mask
    runs = _runs(padded.reshape(-1), padded.view(np.uint64).reshape(-1), padded.shape[1])
    run_labels, boxes = _merge_runs(runs, smallest_area)
    return _paint_labels(runs, run_labels, height, width), boxes


@njit(cache=True)
def _runs(pixels: Pixels, chunks: NDArray[np.uint64], stride: int) -> NDArray[np.int32]:
    # Runs of nonzero pixels: row, first and last (exclusive) column.
    runs = np.empty((1024, 3), np.int32)
    count, inside = 0, False
    for chunk in range(len(chunks)):
        if not inside and chunks[chunk] == 0:
            continue
        for pixel in range(chunk * _PIXELS_PER_CHUNK, (chunk + 1) * _PIXELS_PER_CHUNK):
            if (pixels[pixel] != 0) == inside:
                continue
            if inside:
                runs[count, 2] = pixel % stride
                count += 1
            else:
                if count == len(runs):
                    runs = np.concatenate((runs, np.empty_like(runs)))
                runs[count, 0], runs[count, 1] = pixel // stride, pixel % stride
            inside = not inside
    return runs[:count]


@njit(cache=True)
def _merge_runs(runs: NDArray[np.int32], smallest_area: float) -> tuple[NDArray[np.int32], Boxes]:
    # Label of each run, 0 for specks, and the boxes.
    parents = _connect_to_row_above(runs)
    numbers = np.full(len(runs), -1, np.int32)
    boxes = np.empty((len(runs), 5), np.int32)
    count = 0
    for k in range(len(runs)):
        row, left, right = runs[k]
        parents[k] = parents[parents[k]]
        if parents[k] == k:
            numbers[k] = count
            boxes[count, 0], boxes[count, 1] = left, row
            boxes[count, 2:] = 0
            count += 1
        box = boxes[numbers[parents[k]]]
        box[0], box[2] = min(box[0], left), max(box[2], right)
        box[3] = row + 1
        box[4] += right - left
    large = boxes[:count, 4] >= smallest_area
    labels = np.cumsum(large).astype(np.int32) * large
    run_labels = np.empty(len(runs), np.int32)
    for k in range(len(runs)):
        run_labels[k] = labels[numbers[parents[k]]]
    return run_labels, boxes[:count][large]


@njit(cache=True)
def _connect_to_row_above(runs: NDArray[np.int32]) -> NDArray[np.int32]:
    # Union-find: each run's parent in a forest whose roots are the first runs of the blobs.
    parents = np.arange(len(runs), dtype=np.int32)
    above = 0
    for k in range(len(runs)):
        row, left, right = runs[k]
        while runs[above, 0] < row - 1 or (runs[above, 0] == row - 1 and runs[above, 2] <= left):
            above += 1
        other = above
        while runs[other, 0] == row - 1 and runs[other, 1] < right:
            one, two = find_root(parents, k), find_root(parents, other)
            parents[max(one, two)] = min(one, two)
            other += 1
    return parents


@njit(cache=True)
def find_root(parents: NDArray[np.signedinteger], node: int) -> int:
    """Return the root of a node of a union-find forest, and halve the path to it."""
    while parents[node] != node:
        parents[node] = parents[parents[node]]
        node = parents[node]
    return node


@njit(cache=True)
def _paint_labels(runs: NDArray[np.int32], run_labels: NDArray[np.int32], height: int, width: int) -> Labels:
    labels = np.zeros((height, width), np.int32)
    for k in range(len(runs)):
        if run_labels[k]:
            labels[runs[k, 0], runs[k, 1] : runs[k, 2]] = run_labels[k]
    return labels


@njit(cache=True)
def bounding_boxes(labels: Labels, count: int) -> Boxes:
    """Return the bounding boxes of the labels 1 to ``count``."""
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


def grow_labels(labels: Labels, boxes: Boxes) -> None:
    """Grow all blobs into the floor simultaneously, in place; the border between two blobs is halfway.

    Floor pixels in a soft edge get the label of their blob, those in a ring its negative; the boxes are not modified.
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
def _outline(labels: Labels, boxes: Boxes) -> Ints:
    height, width = labels.shape
    outline = np.empty(np.sum(boxes[:, 4]), np.int64)
    count = 0
    for i in range(len(boxes)):
        left, top, right, bottom = max(1, boxes[i, 0]), max(1, boxes[i, 1]), boxes[i, 2], boxes[i, 3]
        for v in range(top, min(bottom, height - 1)):
            for u in range(left, min(right, width - 1)):
                if labels[v, u] == i + 1 and (
                    labels[v, u - 1] == 0 or labels[v, u + 1] == 0 or labels[v - 1, u] == 0 or labels[v + 1, u] == 0
                ):
                    outline[count] = v * width + u
                    count += 1
    return outline[:count]
