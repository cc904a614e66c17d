"""Bounding boxes of images in an array store; a two-level search finds those that overlap a tile."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.tiles import Tile

_TOGETHER = 32
"""Number of consecutive images with a common bounding box, which is tested first."""


@dataclass(frozen=True)
class ImageBoxes:
    """Bounding boxes of all images.

    Attributes:
        shelf: array store of the boxes.
    """

    shelf: Shelf

    def meeting(self, tile: Tile) -> NDArray[np.int64]:
        """Return the images whose boxes overlap a tile, ascending, shape (k,)."""
        groups = np.flatnonzero(_meets(self.shelf.look_up('boxes_together'), tile))
        boxes = self.shelf.look_up('boxes')
        images = (_TOGETHER * groups[:, None] + np.arange(_TOGETHER)).ravel()
        images = images[images < len(boxes)]
        return images[_meets(boxes[images], tile)]


def shelve_boxes(boxes: NDArray[np.float64], shelf: Shelf) -> ImageBoxes:
    """Store boxes; they replace the previous ones.

    Args:
        boxes: lower left and upper right corner of the box of each image, shape (k, 2, 2) [m].
        shelf: array store.
    """
    first = np.arange(0, len(boxes), _TOGETHER)
    together = [np.minimum.reduceat(boxes[:, 0], first), np.maximum.reduceat(boxes[:, 1], first)]
    shelf.put('boxes', 0, boxes)
    shelf.put('boxes_together', 0, np.stack(together, axis=1))
    return ImageBoxes(shelf)


def _meets(boxes: NDArray[np.float64], tile: Tile) -> NDArray[np.bool_]:
    return np.asarray(((boxes[:, 1] >= tile.lower) & (boxes[:, 0] < tile.upper)).all(axis=1))
