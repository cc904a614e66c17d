"""Boxes around what images show, on a shelf: those of a place are found without a look at each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.tiles import Tile

_TOGETHER = 32
"""Images that follow each other in the drive have a box around theirs, which is looked at first."""


@dataclass(frozen=True)
class ImageBoxes:
    """Boxes of all images.

    Attributes:
        shelf: where they are.
    """

    shelf: Shelf

    def meeting(self, tile: Tile) -> NDArray[np.int64]:
        """Return the images whose boxes meet a tile, shape (k,), rising."""
        groups = np.flatnonzero(_meets(self.shelf.look_up('boxes_together'), tile))
        boxes = self.shelf.look_up('boxes')
        images = (_TOGETHER * groups[:, None] + np.arange(_TOGETHER)).ravel()
        images = images[images < len(boxes)]
        return images[_meets(boxes[images], tile)]


def shelve_boxes(boxes: NDArray[np.float64], shelf: Shelf) -> ImageBoxes:
    """Put boxes on a shelf, in the place of those before.

    Args:
        boxes: shape (k, 2, 2), lower left and upper right corner of each image's [m].
        shelf: for them.
    """
    first = np.arange(0, len(boxes), _TOGETHER)
    together = [np.minimum.reduceat(boxes[:, 0], first), np.maximum.reduceat(boxes[:, 1], first)]
    shelf.put('boxes', 0, boxes)
    shelf.put('boxes_together', 0, np.stack(together, axis=1))
    return ImageBoxes(shelf)


def _meets(boxes: NDArray[np.float64], tile: Tile) -> NDArray[np.bool_]:
    return np.asarray(((boxes[:, 1] >= tile.lower) & (boxes[:, 0] < tile.upper)).all(axis=1))
