"""The map of the whole area, into which the local maps are written (2.2.3, step 2)."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.grid.occupancy_map import UNKNOWN
from reward_planner.core.mapping.local_map import LocalMap
from reward_planner.core.mapping.mapping_error import MappingError

_BLOCK = 64
_Part = tuple[slice, slice]


class GlobalMap:
    """Cells in the map frame, in blocks where something is known; memory grows with the ground that was seen.

    Attributes:
        resolution: side of a cell [m]; cell borders lie at its multiples.
        cells_max: so many cells are kept at most, and no part in which routes are sought may have more.
        refused: cells that were not written because the map would have become too large.
    """

    def __init__(self, resolution: float, cells_max: int) -> None:
        """Begin with nothing known.

        Args:
            resolution: side of a cell [m].
            cells_max: so many cells are kept at most.
        """
        self.resolution = resolution
        self.refused = 0
        self.cells_max = cells_max
        self._blocks: dict[tuple[int, int], NDArray[np.int8]] = {}
        self._low = self._high = (0, 0)

    @property
    def bytes(self) -> int:
        """Memory of the cells."""
        return len(self._blocks) * _BLOCK**2

    def write(self, local: LocalMap) -> None:
        """Overwrite the cells that a local map observed; all others stay what they were, whatever the time.

        Cells of a known map that are not in step with this map's cells go to the nearest ones.

        Raises:
            MappingError: cells of another size, or arrays that do not fit their frame.
        """
        if local.occupancy.shape != local.frame.shape or local.observed.shape != local.frame.shape:
            raise MappingError(
                f'occupancy has the shape {local.occupancy.shape}, its frame {local.frame.shape}; they must be equal'
            )
        for place, block, part in self._parts(local.frame):
            observed = local.observed[part]
            if not observed.any():
                continue
            if place not in self._blocks and not self._add_block(place):
                self.refused += int(observed.sum())
                continue
            self._blocks[place][block][observed] = local.occupancy[part][observed]

    def frame(self) -> GridFrame | None:
        """Return the smallest rectangle of blocks around all that is known, None while nothing is."""
        if not self._blocks:
            return None
        metres = _BLOCK * self.resolution
        rows, columns = (_BLOCK * (high - low) for low, high in zip(self._low, self._high, strict=True))
        return GridFrame(self._low[1] * metres, self._low[0] * metres, self.resolution, columns, rows)

    def occupancy(self) -> tuple[GridFrame, NDArray[np.int8]] | None:
        """Return all cells as an array of shape (rows, columns) and their frame, None while nothing is known.

        Raises:
            MappingError: the rectangle around all that is known has more than cells_max cells.
        """
        frame = self.frame()
        if frame is None:
            return None
        if frame.rows * frame.columns > self.cells_max:
            raise MappingError(
                f'the map is {frame.columns} x {frame.rows} cells large, cells_max is {self.cells_max}; '
                'raise it or take a part of the map'
            )
        return frame, self.occupancy_in(frame)

    def occupancy_in(self, frame: GridFrame) -> NDArray[np.int8]:
        """Return the cells of a frame, shape (rows, columns), UNKNOWN where nothing is known.

        Raises:
            MappingError: cells of another size.
        """
        cells = np.full(frame.shape, UNKNOWN, dtype=np.int8)
        for place, block, part in self._parts(frame):
            if place in self._blocks:
                cells[part] = self._blocks[place][block]
        return cells

    def clear(self) -> None:
        """Forget everything."""
        self._blocks.clear()

    def _parts(self, frame: GridFrame) -> Iterator[tuple[tuple[int, int], _Part, _Part]]:
        """Yield the blocks that a frame touches: place, which of the block's cells, and which of the frame's."""
        if not math.isclose(frame.resolution, self.resolution, rel_tol=1e-6):
            raise MappingError(
                f'the cells are {frame.resolution} m wide and those of the map {self.resolution} m; '
                'use the same resolution'
            )
        row, column = round(frame.origin_y / self.resolution), round(frame.origin_x / self.resolution)
        for block_row, rows, frame_rows in _cuts(row, frame.rows):
            for block_column, columns, frame_columns in _cuts(column, frame.columns):
                yield (block_row, block_column), (rows, columns), (frame_rows, frame_columns)

    def _add_block(self, place: tuple[int, int]) -> bool:
        """Make a block with nothing known; return whether there was room for it."""
        if (len(self._blocks) + 1) * _BLOCK**2 > self.cells_max:
            return False
        low, high = place, (place[0] + 1, place[1] + 1)
        if self._blocks:
            low = (min(low[0], self._low[0]), min(low[1], self._low[1]))
            high = (max(high[0], self._high[0]), max(high[1], self._high[1]))
        self._low, self._high = low, high
        self._blocks[place] = np.full((_BLOCK, _BLOCK), UNKNOWN, dtype=np.int8)
        return True


def _cuts(first: int, count: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield the blocks along one axis that ``count`` cells from ``first`` on touch, with the cells in block and row."""
    for block in range(first // _BLOCK, (first + count - 1) // _BLOCK + 1):
        start, end = max(block * _BLOCK, first), min((block + 1) * _BLOCK, first + count)
        yield block, slice(start - block * _BLOCK, end - block * _BLOCK), slice(start - first, end - first)
