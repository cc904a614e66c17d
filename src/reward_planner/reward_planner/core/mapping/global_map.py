"""The global occupancy grid, updated from local maps (2.2.3, step 2).

The local map around the robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.occupancy_map import UNKNOWN, GridFrame
from reward_planner.core.reward_planner_error import MappingError

_BLOCK = 64
_CellSlices = tuple[slice, slice]


class GlobalMap:
    """Occupancy grid in the map frame, stored in blocks; memory grows with the observed area.

    Attributes:
        resolution: side of a cell [m]; cell borders are at its multiples.
        cells_max: maximum number of cells of the map and of a costmap.
        rejected_cells: number of cells that were not written because the map is full.
    """

    def __init__(self, resolution: float, cells_max: int) -> None:
        """Start with an empty map.

        Args:
            resolution: side of a cell [m].
            cells_max: maximum number of cells.
        """
        self.resolution = resolution
        self.rejected_cells = 0
        self.cells_max = cells_max
        self._blocks: dict[tuple[int, int], NDArray[np.int8]] = {}
        self._low = self._high = (0, 0)

    @property
    def bytes(self) -> int:
        """Memory of the cells [bytes]."""
        return len(self._blocks) * _BLOCK**2

    def write(self, local: LocalMap) -> None:
        """Overwrite the cells that a local map observed; all others stay unchanged.

        Cells of a static map that are not aligned with this map's cells are moved to the nearest ones.

        Raises:
            MappingError: another resolution, or arrays that do not fit their frame.
        """
        if local.occupancy.shape != local.frame.shape or local.observed.shape != local.frame.shape:
            raise MappingError(
                f'occupancy has the shape {local.occupancy.shape}, its frame {local.frame.shape}; they must be equal'
            )
        for index, block, part in self._overlapping_blocks(local.frame):
            observed = local.observed[part]
            if not observed.any():
                continue
            if index not in self._blocks and not self._add_block(index):
                self.rejected_cells += int(observed.sum())
                continue
            self._blocks[index][block][observed] = local.occupancy[part][observed]

    def frame(self) -> GridFrame | None:
        """Return the smallest rectangle of blocks around all known cells, None if there are none."""
        if not self._blocks:
            return None
        metres = _BLOCK * self.resolution
        rows, columns = (_BLOCK * (high - low) for low, high in zip(self._low, self._high, strict=True))
        return GridFrame(self._low[1] * metres, self._low[0] * metres, self.resolution, columns, rows)

    def occupancy(self) -> tuple[GridFrame, NDArray[np.int8]] | None:
        """Return frame and cells of the whole map, shape (rows, columns), None if the map is empty.

        Raises:
            MappingError: the rectangle around all known cells has more than cells_max cells.
        """
        frame = self.frame()
        if frame is None:
            return None
        if frame.rows * frame.columns > self.cells_max:
            raise MappingError(
                f'the map has {frame.columns} x {frame.rows} cells, cells_max is {self.cells_max}; '
                'raise it or use a part of the map'
            )
        return frame, self.occupancy_in(frame)

    def occupancy_in(self, frame: GridFrame) -> NDArray[np.int8]:
        """Return the cells of a frame, shape (rows, columns), UNKNOWN by default.

        Raises:
            MappingError: another resolution.
        """
        cells = np.full(frame.shape, UNKNOWN, dtype=np.int8)
        for index, block, part in self._overlapping_blocks(frame):
            if index in self._blocks:
                cells[part] = self._blocks[index][block]
        return cells

    def clear(self) -> None:
        """Clear the map."""
        self._blocks.clear()

    def _overlapping_blocks(
        self, frame: GridFrame
    ) -> Iterator[tuple[tuple[int, int], _CellSlices, _CellSlices]]:
        """Yield the blocks that overlap a frame: block index, cells of the block, cells of the frame."""
        if not math.isclose(frame.resolution, self.resolution, rel_tol=1e-6):
            raise MappingError(
                f'the resolution is {frame.resolution} m, that of the map {self.resolution} m; '
                'use the same resolution'
            )
        row, column = round(frame.origin_y / self.resolution), round(frame.origin_x / self.resolution)
        for block_row, rows, frame_rows in _split_by_blocks(row, frame.rows):
            for block_column, columns, frame_columns in _split_by_blocks(column, frame.columns):
                yield (block_row, block_column), (rows, columns), (frame_rows, frame_columns)

    def _add_block(self, index: tuple[int, int]) -> bool:
        """Allocate a block of unknown cells; return False if the map is full."""
        if (len(self._blocks) + 1) * _BLOCK**2 > self.cells_max:
            return False
        low, high = index, (index[0] + 1, index[1] + 1)
        if self._blocks:
            low = (min(low[0], self._low[0]), min(low[1], self._low[1]))
            high = (max(high[0], self._high[0]), max(high[1], self._high[1]))
        self._low, self._high = low, high
        self._blocks[index] = np.full((_BLOCK, _BLOCK), UNKNOWN, dtype=np.int8)
        return True


def _split_by_blocks(first: int, count: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield the blocks along one axis that overlap ``count`` cells from ``first``, with their cells."""
    for block in range(first // _BLOCK, (first + count - 1) // _BLOCK + 1):
        start, end = max(block * _BLOCK, first), min((block + 1) * _BLOCK, first + count)
        yield block, slice(start - block * _BLOCK, end - block * _BLOCK), slice(start - first, end - first)


@dataclass(frozen=True)
class LocalMap:
    """Occupancy of the floor around the robot, from its voxels.

    Attributes:
        frame: origin, resolution and size of the grid.
        occupancy: OCCUPIED, FREE or UNKNOWN, shape (rows, columns).
        observed: cells to write to the global map, shape (rows, columns): occupied, free, and UNKNOWN ones whose
            obstacle was cleared by rays. Decayed or partial evidence does not count.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]
    observed: NDArray[np.bool_]
