"""Sightings of all images put into blocks, tile by tile: never more in memory than a tile and its surroundings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.placed_sightings import Placed, place_sightings
from floor_localizer.core.survey.shelf import Shelf
from floor_localizer.core.survey.sighting_blocks import SightingBlock, SightingBlocks
from floor_localizer.core.survey.sightings import chains, merge_sightings
from floor_localizer.core.survey.survey_image import SurveyImage
from floor_localizer.core.survey.tiles import Tile, cut_tiles

_IMAGES_A_TILE = 64
# How far around a tile its dots are looked for at first: in reaches.
_HALO = 8.0


class BlockCutter:
    """Cuts the sightings of a survey into blocks."""

    def __init__(
        self, images: Sequence[SurveyImage], position: NDArray[np.float64], dot_sigma: float, shelf: Shelf,
        images_a_tile: int = _IMAGES_A_TILE,
    ) -> None:  # fmt: skip
        """Begin.

        Args:
            images: those that are on the map.
            position: of the optical centre [m].
            dot_sigma: accuracy of a dot on the floor besides noise [m].
            shelf: for the blocks.
            images_a_tile: at most.
        """
        self._images, self._position, self._dot_sigma = images, position, dot_sigma
        self._shelf, self._images_a_tile = shelf, images_a_tile

    def cut(self, states: NDArray[np.float64], reach: float) -> SightingBlocks:
        """Return all sightings, those within reach of each other as one dot (see `merge_sightings`).

        Args:
            states: shape (k, 6), of all images.
            reach: of the same dot [m].
        """
        lower, upper = self._extents(states)
        tiles = cut_tiles(0.5 * (lower + upper), self._images_a_tile)
        blocks = SightingBlocks(self._shelf, len(tiles))
        for number, tile in enumerate(tiles):
            blocks.put(number, self._block(tile, states, lower, upper, reach))
        return blocks

    def _extents(self, states: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the corners of what each image shows, shape (k, 2) each [m]; of nothing for one without dots."""
        lower, upper = np.zeros((len(states), 2)), np.zeros((len(states), 2))
        for number in range(len(states)):
            points = self._placed(np.array([number]), states).points
            if len(points):
                lower[number], upper[number] = points.min(axis=0), points.max(axis=0)
        return lower, upper

    def _placed(self, numbers: NDArray[np.int64], states: NDArray[np.float64]) -> Placed:
        return place_sightings(self._images, numbers, states, self._position, self._dot_sigma)

    def _block(
        self,
        tile: Tile,
        states: NDArray[np.float64],
        lower: NDArray[np.float64],
        upper: NDArray[np.float64],
        reach: float,
    ) -> SightingBlock:
        """Return the sightings of the dots whose first sighting lies in a tile."""
        halo = _HALO * reach
        while True:
            around = tile.grown(halo)
            near = np.flatnonzero(((upper >= around.lower) & (lower < around.upper)).all(axis=1))
            placed = self._placed(near, states)
            placed = placed.where(around.contains(placed.points))
            if _is_whole(placed, tile, tile.grown(halo - reach), reach):
                return _owned(placed, tile, reach)
            halo *= 2.0


def _is_whole(placed: Placed, tile: Tile, safe: Tile, reach: float) -> bool:
    """Tell whether no chain that comes into the tile may go on beyond what is there."""
    chain = chains(placed.points, placed.seen.image, reach)
    inside = np.zeros(len(chain) + 1, dtype=np.bool_)
    inside[chain[tile.contains(placed.points)]] = True
    return not inside[chain[~safe.contains(placed.points)]].any()


def _owned(placed: Placed, tile: Tile, reach: float) -> SightingBlock:
    dot = merge_sightings(placed.points, placed.seen.image, reach)
    _, first = np.unique(dot, return_index=True)
    kept = tile.contains(placed.points)[first][dot]
    _, renumbered = np.unique(dot[kept], return_inverse=True)
    seen = replace(placed.seen.where(kept), dot=renumbered.astype(np.int64))
    return SightingBlock(seen, np.full((int(renumbered.max(initial=-1)) + 1, 2), np.nan))
