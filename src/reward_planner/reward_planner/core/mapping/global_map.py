"""The map of the whole area, into which the local maps are written (2.2.3, step 2)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.mapping.local_map import UNKNOWN, LocalMap
from reward_planner.core.mapping.mapping_error import MappingError

_BLOCK = 64


class GlobalMap:
    """Cells in the map frame, in blocks where something is known; memory grows with the ground that was seen.

    Attributes:
        resolution: side of a cell [m]; cell borders lie at its multiples.
        refused: cells that were not written because the map would have become too large.
    """

    def __init__(self, resolution: float, cells_max: int) -> None:
        """Begin with nothing known.

        Args:
            resolution: side of a cell [m].
            cells_max: the rectangle around all blocks has so many cells at most.
        """
        self.resolution = resolution
        self.refused = 0
        self._cells_max = cells_max
        self._blocks: dict[tuple[int, int], NDArray[np.int8]] = {}
        self._low = self._high = (0, 0)

    @property
    def bytes(self) -> int:
        """Memory of the cells."""
        return len(self._blocks) * _BLOCK**2

    def write(self, local: LocalMap) -> None:
        """Overwrite the cells for which a local map has evidence.

        Cells of a known map that are not in step with this map's cells go to the nearest ones.

        Raises:
            MappingError: cells of another size, or arrays that do not fit their frame.
        """
        frame = local.frame
        if not math.isclose(frame.resolution, self.resolution, rel_tol=1e-6):
            raise MappingError(
                f'the cells are {frame.resolution} m wide and those of the map {self.resolution} m; '
                'use the same resolution'
            )
        if local.occupancy.shape != frame.shape or local.observed.shape != frame.shape:
            raise MappingError(
                f'occupancy has the shape {local.occupancy.shape}, its frame {frame.shape}; they must be equal'
            )
        row, column = round(frame.origin_y / self.resolution), round(frame.origin_x / self.resolution)
        for block_row in range(row // _BLOCK, (row + frame.rows - 1) // _BLOCK + 1):
            for block_column in range(column // _BLOCK, (column + frame.columns - 1) // _BLOCK + 1):
                corner = (block_row * _BLOCK - row, block_column * _BLOCK - column)
                self._write_block((block_row, block_column), corner, local)

    def frame(self) -> GridFrame | None:
        """Return the smallest rectangle of blocks around all that is known, None while nothing is."""
        if not self._blocks:
            return None
        metres = _BLOCK * self.resolution
        rows, columns = (_BLOCK * (high - low) for low, high in zip(self._low, self._high, strict=True))
        return GridFrame(self._low[1] * metres, self._low[0] * metres, self.resolution, columns, rows)

    def occupancy(self) -> tuple[GridFrame, NDArray[np.int8]] | None:
        """Return all cells as an array of shape (rows, columns) and their frame, None while nothing is known."""
        frame = self.frame()
        if frame is None:
            return None
        cells = np.full(frame.shape, UNKNOWN, dtype=np.int8)
        for place, block in self._blocks.items():
            row, column = (_BLOCK * (index - low) for index, low in zip(place, self._low, strict=True))
            cells[row : row + _BLOCK, column : column + _BLOCK] = block
        return frame, cells

    def clear(self) -> None:
        """Forget everything."""
        self._blocks.clear()

    def _write_block(self, place: tuple[int, int], corner: tuple[int, int], local: LocalMap) -> None:
        """Write what lies in one block, whose corner is the cell ``corner`` of the local map."""
        starts = [max(first, 0) for first in corner]
        ends = [min(first + _BLOCK, size) for first, size in zip(corner, local.frame.shape, strict=True)]
        source = (slice(starts[0], ends[0]), slice(starts[1], ends[1]))
        observed = local.observed[source]
        if not observed.any():
            return
        if place not in self._blocks and not self._add_block(place):
            self.refused += int(observed.sum())
            return
        target = self._blocks[place][
            starts[0] - corner[0] : ends[0] - corner[0], starts[1] - corner[1] : ends[1] - corner[1]
        ]
        target[observed] = local.occupancy[source][observed]

    def _add_block(self, place: tuple[int, int]) -> bool:
        """Make a block with nothing known; return whether there was room for it."""
        low, high = place, (place[0] + 1, place[1] + 1)
        if self._blocks:
            low = (min(low[0], self._low[0]), min(low[1], self._low[1]))
            high = (max(high[0], self._high[0]), max(high[1], self._high[1]))
        if (high[0] - low[0]) * (high[1] - low[1]) * _BLOCK**2 > self._cells_max:
            return False
        self._low, self._high = low, high
        self._blocks[place] = np.full((_BLOCK, _BLOCK), UNKNOWN, dtype=np.int8)
        return True
