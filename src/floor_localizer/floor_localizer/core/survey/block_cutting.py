"""Partition the observations of all images into blocks, tile by tile; only a tile and its halo are in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.independent_tasks import TaskRunner, run_numbered
from floor_localizer.core.survey.image_boxes import ImageBoxes, shelve_boxes
from floor_localizer.core.survey.placed_sightings import Placed, placed
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.shelved_sightings import ShelvedSightings, shelve_sightings
from floor_localizer.core.survey.sighting_blocks import BLOCKS_A_TASK, SightingBlock, SightingBlocks
from floor_localizer.core.survey.sightings import chains, merge_sightings
from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.core.survey.tiles import Tile, cut_tiles

_IMAGES_A_TILE = 64
# First width of the halo around a tile, in merge distances.
_HALO = 8.0
_GROUPS_A_TASK = 8


class BlockCutter:
    """Partitions the observations of a survey into blocks."""

    def __init__(
        self, images: Sequence[SurveyImage], position: NDArray[np.float64], dot_sigma: float, shelf: Shelf,
        runner: TaskRunner, images_a_tile: int = _IMAGES_A_TILE,
    ) -> None:  # fmt: skip
        """Write the observations to the array store.

        Args:
            images: the images that are on the map.
            position: optical centre in the base frame, shape (3,) [m].
            dot_sigma: standard deviation of a dot on the floor, in addition to image noise [m].
            shelf: array store of the blocks.
            runner: runs the tasks; they must see the array store.
            images_a_tile: maximum number of images per tile.
        """
        self._shelved = shelve_sightings(images, dot_sigma, shelf)
        self._position, self._runner, self._images_a_tile = position, runner, images_a_tile

    def cut(self, states: NDArray[np.float64], reach: float) -> SightingBlocks:
        """Return all observations in blocks, merged into dots by `merge_sightings`.

        Args:
            states: states of all images, shape (k, 6).
            reach: merge distance of observations of one dot [m].
        """
        shelf, groups = self._shelved.shelf, self._shelved.groups
        shelf.put('states', 0, states)
        run_numbered(self._runner, _Extents(self._shelved, self._position), groups, _GROUPS_A_TASK)
        extents = np.concatenate([shelf.get('extents', number)[0] for number in range(groups)])
        tiles = cut_tiles(0.5 * (extents[:, 0] + extents[:, 1]), self._images_a_tile)
        blocks = SightingBlocks(shelf, len(tiles))
        shelf.put('tiles', 0, np.array([(tile.lower, tile.upper) for tile in tiles]))
        cutting = _Cutting(self._shelved, shelve_boxes(extents, shelf), blocks, self._position, reach)
        run_numbered(self._runner, cutting, len(tiles), BLOCKS_A_TASK)
        return blocks


@dataclass(frozen=True)
class _Extents:
    """Stores the bounding box of the dots of each image, shape (k, 2, 2) [m]; zeros for an image without dots."""

    shelved: ShelvedSightings
    position: NDArray[np.float64]

    def __call__(self, number: int) -> None:
        images, seen = self.shelved.of_group(number)
        points = placed(seen, self.shelved.shelf.look_up('states'), self.position).points
        extents = np.zeros((len(images), 2, 2))
        showing, begins = np.unique(seen.image, return_index=True)
        if len(showing):
            extents[showing - images[0], 0] = np.minimum.reduceat(points, begins)
            extents[showing - images[0], 1] = np.maximum.reduceat(points, begins)
        self.shelved.shelf.put('extents', number, extents)


@dataclass(frozen=True)
class _Cutting:
    """Stores the block of a tile: the dots whose first observation is in the tile."""

    shelved: ShelvedSightings
    boxes: ImageBoxes
    blocks: SightingBlocks
    position: NDArray[np.float64]
    reach: float

    def __call__(self, number: int) -> None:
        shelf, halo = self.shelved.shelf, _HALO * self.reach
        tile = Tile(*shelf.look_up('tiles')[number])
        states = shelf.look_up('states')
        while True:
            around = tile.grown(halo)
            seen = self.shelved.of_images(self.boxes.meeting(around))
            sightings = placed(seen, states, self.position)
            sightings = sightings.where(around.contains(sightings.points))
            if _is_whole(sightings, tile, tile.grown(halo - self.reach), self.reach):
                self.blocks.put(number, _owned(sightings, tile, self.reach))
                return
            halo *= 2.0


def _is_whole(sightings: Placed, tile: Tile, safe: Tile, reach: float) -> bool:
    """Return whether every cluster that reaches into the tile is completely inside the halo."""
    chain = chains(sightings.points, sightings.seen.image, reach)
    inside = np.zeros(len(chain) + 1, dtype=np.bool_)
    inside[chain[tile.contains(sightings.points)]] = True
    return not inside[chain[~safe.contains(sightings.points)]].any()


def _owned(sightings: Placed, tile: Tile, reach: float) -> SightingBlock:
    dot = merge_sightings(sightings.points, sightings.seen.image, reach)
    _, first = np.unique(dot, return_index=True)
    kept = tile.contains(sightings.points)[first][dot]
    _, renumbered = np.unique(dot[kept], return_inverse=True)
    seen = replace(sightings.seen.where(kept), dot=renumbered.astype(np.int64))
    return SightingBlock(seen, np.full((int(renumbered.max(initial=-1)) + 1, 2), np.nan))
