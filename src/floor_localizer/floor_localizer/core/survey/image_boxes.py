"""Bounding boxes of images in an array store; a two-level search finds those that overlap a tile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.tiles import Tile

_GROUP_SIZE = 32
"""Number of consecutive images with a common bounding box, which is tested first."""


@dataclass(frozen=True)
class ImageBoxes:
    """Bounding boxes of all images.

    Attributes:
        store: array store of the boxes.
    """

    store: ArrayStore

    def overlapping_images(self, tile: Tile) -> NDArray[np.int64]:
        """Return the images whose boxes overlap a tile, ascending, shape (k,)."""
        groups = np.flatnonzero(_overlaps(self.store.memory_map('group_boxes'), tile))
        boxes = self.store.memory_map('boxes')
        images = (_GROUP_SIZE * groups[:, None] + np.arange(_GROUP_SIZE)).ravel()
        images = images[images < len(boxes)]
        return images[_overlaps(boxes[images], tile)]


def store_boxes(boxes: NDArray[np.float64], store: ArrayStore) -> ImageBoxes:
    """Store boxes; they replace the previous ones.

    Args:
        boxes: lower left and upper right corner of the box of each image, shape (k, 2, 2) [m].
        store: array store.
    """
    first = np.arange(0, len(boxes), _GROUP_SIZE)
    group_boxes = [np.minimum.reduceat(boxes[:, 0], first), np.maximum.reduceat(boxes[:, 1], first)]
    store.put('boxes', 0, boxes)
    store.put('group_boxes', 0, np.stack(group_boxes, axis=1))
    return ImageBoxes(store)


def _overlaps(boxes: NDArray[np.float64], tile: Tile) -> NDArray[np.bool_]:
    return np.asarray(((boxes[:, 1] >= tile.lower) & (boxes[:, 0] < tile.upper)).all(axis=1))
