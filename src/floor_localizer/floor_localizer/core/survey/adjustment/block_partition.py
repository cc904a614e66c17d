"""Partition the observations of all images into blocks, tile by tile; only a tile and its halo are in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from floor_localizer.core.arrays import Booleans, Floats, Ints
from floor_localizer.core.independent_tasks import TaskRunner, run_indexed
from floor_localizer.core.survey.adjustment.observations import (
    ObservationBlock,
    ObservationBlocks,
    ProjectedObservations,
    StoredObservations,
    cluster_observations,
    merge_observations,
    project_observations,
    store_observations,
)
from floor_localizer.core.survey.array_store import ArrayStore
from floor_localizer.core.survey.survey_image import SurveyImage

_GROUP_SIZE = 32  # number of consecutive images with a common bounding box, which is tested first
_IMAGES_PER_TILE = 64
# First width of the halo around a tile, in merge distances.
_HALO = 8.0
_GROUPS_PER_TASK = 8


@dataclass(frozen=True)
class Tile:
    """Axis-aligned rectangle, infinite at the border: lower corner (inclusive), upper (exclusive), (2,) [m]."""

    lower: Floats
    upper: Floats

    def contains(self, points: Floats) -> Booleans:
        """Return whether each point, shape (n, 2), is in the tile."""
        return np.asarray(((points >= self.lower) & (points < self.upper)).all(axis=1))

    def expanded(self, margin: float) -> Tile:
        """Return the tile expanded by a margin [m]."""
        return Tile(self.lower - margin, self.upper + margin)


def split_into_tiles(centres: Floats, capacity: int) -> list[Tile]:
    """Bisect the plane (k-d tree) until no tile contains more than ``capacity`` centres, shape (n, 2) [m].

    The tiles cover the plane without gaps, in the order of the tree's leaves, so consecutive tiles are neighbours.
    """
    halvings = 0
    while len(centres) > capacity << halvings:
        halvings += 1
    return _bisect(centres, Tile(np.full(2, -np.inf), np.full(2, np.inf)), halvings)


def _bisect(centres: Floats, tile: Tile, halvings: int) -> list[Tile]:
    if halvings == 0 or len(centres) == 0:
        return [tile]
    axis = int(np.argmax(np.ptp(centres, axis=0)))
    cut = float(np.median(centres[:, axis]))
    is_below = centres[:, axis] < cut
    upper, lower = tile.upper.copy(), tile.lower.copy()
    upper[axis] = lower[axis] = cut
    return [
        *_bisect(centres[is_below], Tile(tile.lower, upper), halvings - 1),
        *_bisect(centres[~is_below], Tile(lower, tile.upper), halvings - 1),
    ]


@dataclass(frozen=True)
class ImageBoxes:
    """Bounding boxes of all images, in an array store."""

    store: ArrayStore

    def overlapping_images(self, tile: Tile) -> Ints:
        """Return the images whose boxes overlap a tile, ascending, shape (k,)."""
        groups = np.flatnonzero(_overlaps(self.store.memory_map('group_boxes'), tile))
        boxes = self.store.memory_map('boxes')
        images = (_GROUP_SIZE * groups[:, None] + np.arange(_GROUP_SIZE)).ravel()
        images = images[images < len(boxes)]
        return images[_overlaps(boxes[images], tile)]


def store_boxes(boxes: Floats, store: ArrayStore) -> ImageBoxes:
    """Store lower left and upper right corner of each image's box, shape (k, 2, 2) [m], in place of earlier ones."""
    first = np.arange(0, len(boxes), _GROUP_SIZE)
    group_boxes = [np.minimum.reduceat(boxes[:, 0], first), np.maximum.reduceat(boxes[:, 1], first)]
    store.put('boxes', 0, boxes)
    store.put('group_boxes', 0, np.stack(group_boxes, axis=1))
    return ImageBoxes(store)


def _overlaps(boxes: Floats, tile: Tile) -> Booleans:
    return np.asarray(((boxes[:, 1] >= tile.lower) & (boxes[:, 0] < tile.upper)).all(axis=1))


class BlockPartitioner:
    """Partitions the observations of a survey into blocks."""

    def __init__(
        self,
        images: Sequence[SurveyImage],
        chosen: Ints,
        position: Floats,
        dot_sigma: float,
        store: ArrayStore,
        runner: TaskRunner,
        images_per_tile: int = _IMAGES_PER_TILE,
    ) -> None:
        """Write the observations of the chosen images, those on the map, to the array store of the blocks.

        ``dot_sigma`` is the standard deviation of a dot on the floor, in addition to image noise [m].
        """
        self._stored = store_observations(images, chosen, dot_sigma, store)
        self._position, self._runner, self._images_per_tile = position, runner, images_per_tile

    def partition(self, states: Floats, merge_distance: float) -> ObservationBlocks:
        """Return all observations in blocks, merged into dots by `merge_observations` at a merge distance [m]."""
        store, group_count = self._stored.store, self._stored.group_count
        store.put('states', 0, states)
        run_indexed(self._runner, partial(_store_extents, self._stored, self._position), group_count, _GROUPS_PER_TASK)
        extents = np.concatenate([store.get('extents', number)[0] for number in range(group_count)])
        tiles = split_into_tiles(0.5 * (extents[:, 0] + extents[:, 1]), self._images_per_tile)
        blocks = ObservationBlocks(store, len(tiles))
        store.put('tiles', 0, np.array([(tile.lower, tile.upper) for tile in tiles]))
        boxes = store_boxes(extents, store)
        blocks.for_each(self._runner, _store_block, self._stored, boxes, self._position, merge_distance)
        return blocks


def _store_extents(stored: StoredObservations, position: Floats, number: int) -> None:
    """Store the bounding box of the dots of each image, shape (k, 2, 2) [m]; zeros for an image without dots."""
    images, observations = stored.images_of_group(number), stored.read_group(number)
    points = project_observations(observations, stored.store.memory_map('states'), position).points
    extents = np.zeros((len(images), 2, 2))
    images_with_dots, begins = np.unique(observations.image, return_index=True)
    if len(images_with_dots):
        extents[images_with_dots - images[0], 0] = np.minimum.reduceat(points, begins)
        extents[images_with_dots - images[0], 1] = np.maximum.reduceat(points, begins)
    stored.store.put('extents', number, extents)


def _store_block(
    blocks: ObservationBlocks,
    stored: StoredObservations,
    boxes: ImageBoxes,
    position: Floats,
    merge_distance: float,
    number: int,
) -> None:
    """Store the block of a tile: the dots whose first observation is in the tile."""
    store, halo = stored.store, _HALO * merge_distance
    tile = Tile(*store.memory_map('tiles')[number])
    states = store.memory_map('states')
    while True:
        expanded_tile = tile.expanded(halo)
        observations = stored.read_images(boxes.overlapping_images(expanded_tile))
        projected = project_observations(observations, states, position)
        projected = projected.where(expanded_tile.contains(projected.points))
        if _is_complete(projected, tile, tile.expanded(halo - merge_distance), merge_distance):
            blocks.put(number, _block_of_tile(projected, tile, merge_distance))
            return
        halo *= 2.0


def _is_complete(projected: ProjectedObservations, tile: Tile, safe: Tile, merge_distance: float) -> bool:
    """Return whether every cluster that reaches into the tile is completely inside the halo."""
    cluster = cluster_observations(projected.points, projected.observations.image, merge_distance)
    inside = np.zeros(len(cluster) + 1, dtype=np.bool_)
    inside[cluster[tile.contains(projected.points)]] = True
    return not inside[cluster[~safe.contains(projected.points)]].any()


def _block_of_tile(projected: ProjectedObservations, tile: Tile, merge_distance: float) -> ObservationBlock:
    dot = merge_observations(projected.points, projected.observations.image, merge_distance)
    _, first = np.unique(dot, return_index=True)
    kept = tile.contains(projected.points)[first][dot]
    _, renumbered = np.unique(dot[kept], return_inverse=True)
    observations = replace(projected.observations.where(kept), dot=renumbered.astype(np.int64))
    return ObservationBlock(observations, np.full((int(renumbered.max(initial=-1)) + 1, 2), np.nan))
