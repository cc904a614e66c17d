"""The local map around the robot, and the global map that local maps update (2.2.3, steps 2 and 3)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.occupancy_map import OCCUPIED, UNKNOWN, GridFrame, OccupancyMap, resample_map
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import LETHAL

_FRACTION_MIN = 0.05  # slowest speed of a mask: the robot can leave the zone [of the maximum]


@dataclass(frozen=True)
class SpeedMask:
    """Speed zones: a cell of value v limits the speed to base + multiplier v; 0 and unknown cells do not.

    Attributes:
        grid: values of 0 to 100, or unknown.
        is_percentage: whether limits are in percent of the maximum speed, else in m/s.
        base: base of CostmapFilterInfo, in the unit of the limits.
        multiplier: multiplier of CostmapFilterInfo.
    """

    grid: OccupancyMap
    is_percentage: bool
    base: float
    multiplier: float

    def limit_at(self, x: float, y: float, speed_max: float) -> float:
        """Return the limit at a place in the map [m] from the maximum speed, from 5 % of it up [m/s]."""
        row, column = self.grid.frame.cell_of((x, y))
        value = int(self.grid.occupancy[row, column]) if self.grid.frame.contains((row, column)) else 0
        if value <= 0:
            return speed_max
        limit = self.base + self.multiplier * value
        if self.is_percentage:
            limit *= 0.01 * speed_max
        return min(max(limit, _FRACTION_MIN * speed_max), speed_max)


@dataclass(frozen=True)
class CostmapMasks:
    """The masks of a map.

    Attributes:
        keepout: cells of 100 are not entered by the robot's centre, lower values above 0 are costs.
        speed: speed zones.
    """

    keepout: OccupancyMap | None = None
    speed: SpeedMask | None = None

    def keepout_costs(self, frame: GridFrame) -> NDArray[np.uint8] | None:
        """Return the costs of the cells of a frame, uint8, shape (rows, columns); None without a mask."""
        if self.keepout is None:
            return None
        values = np.maximum(resample_map(self.keepout, frame), 0)
        return (values.astype(np.int64) * LETHAL // OCCUPIED).astype(np.uint8)

    def speed_limit(self, x: float, y: float, speed_max: float) -> float:
        """Return the speed limit at a place in the map [m] from the maximum speed [m/s]."""
        return speed_max if self.speed is None else self.speed.limit_at(x, y, speed_max)


_BLOCK = 64
_CellSlices = tuple[slice, slice]


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


class GlobalMap:
    """Occupancy grid in the map frame, stored in blocks; memory grows with the observed area.

    Attributes:
        resolution: side of a cell [m]; cell borders are at its multiples.
        cells_max: maximum number of cells of the map and of a costmap.
        rejected_cells: number of cells that were not written because the map is full.
        masks: keep-out and speed masks; they stay when the map is cleared.
    """

    def __init__(self, resolution: float, cells_max: int) -> None:
        """Start with an empty map."""
        self.resolution, self.cells_max = resolution, cells_max
        self.rejected_cells = 0
        self.masks = CostmapMasks()
        self._blocks: dict[tuple[int, int], NDArray[np.int8]] = {}

    @property
    def bytes(self) -> int:
        """Memory of the cells [bytes]."""
        return len(self._blocks) * _BLOCK**2

    def write(self, local: LocalMap) -> None:
        """Overwrite the cells that a local map observed; all others stay unchanged.

        Cells of a static map that are not aligned with this map's cells are moved to the nearest ones.

        Raises:
            RewardPlannerError: another resolution, or arrays that do not fit their frame.
        """
        if local.occupancy.shape != local.frame.shape or local.observed.shape != local.frame.shape:
            raise RewardPlannerError(
                f'occupancy has the shape {local.occupancy.shape}, its frame {local.frame.shape}; they must be equal'
            )
        for index, block, part in self._overlapping_blocks(local.frame):
            observed = local.observed[part]
            if not observed.any():
                continue
            if index not in self._blocks and (len(self._blocks) + 1) * _BLOCK**2 > self.cells_max:
                self.rejected_cells += int(observed.sum())
                continue
            # A new block: snapshots keep the old one.
            known = self._blocks.get(index)
            cells = np.full((_BLOCK, _BLOCK), UNKNOWN, dtype=np.int8) if known is None else known.copy()
            cells[block][observed] = local.occupancy[part][observed]
            self._blocks[index] = cells

    def snapshot(self) -> GlobalMap:
        """Return a copy that later changes of either map leave as it is, for another thread; it shares the blocks."""
        snapshot = copy(self)
        snapshot.replace_by(self)
        return snapshot

    def replace_by(self, other: GlobalMap) -> None:
        """Take the cells of another map of the same resolution."""
        self._blocks = dict(other._blocks)

    def frame(self) -> GridFrame | None:
        """Return the smallest rectangle of blocks around all known cells, None if there are none."""
        if not self._blocks:
            return None
        (low_row, rows), (low_column, columns) = (
            (min(n), _BLOCK * (max(n) + 1 - min(n))) for n in zip(*self._blocks, strict=True)
        )
        metres = _BLOCK * self.resolution
        return GridFrame(low_column * metres, low_row * metres, self.resolution, columns, rows)

    def occupancy(self) -> tuple[GridFrame, NDArray[np.int8]] | None:
        """Return frame and cells of the whole map, shape (rows, columns), None if the map is empty.

        Raises:
            RewardPlannerError: the rectangle around all known cells has more than cells_max cells.
        """
        frame = self.frame()
        if frame is None:
            return None
        if frame.size > self.cells_max:
            raise RewardPlannerError(
                f'the map has {frame.columns} x {frame.rows} cells, cells_max is {self.cells_max}; '
                'raise it or use a part of the map'
            )
        return frame, self.occupancy_in(frame)

    def occupancy_in(self, frame: GridFrame) -> NDArray[np.int8]:
        """Return the cells of a frame of the map's resolution, shape (rows, columns), UNKNOWN by default."""
        cells = np.full(frame.shape, UNKNOWN, dtype=np.int8)
        for index, block, part in self._overlapping_blocks(frame):
            if index in self._blocks:
                cells[part] = self._blocks[index][block]
        return cells

    def clear(self) -> None:
        """Clear the map."""
        self._blocks.clear()

    def _overlapping_blocks(self, frame: GridFrame) -> Iterator[tuple[tuple[int, int], _CellSlices, _CellSlices]]:
        """Yield the blocks that overlap a frame: block index, cells of the block, cells of the frame."""
        if not math.isclose(frame.resolution, self.resolution, rel_tol=1e-6):
            raise RewardPlannerError(
                f'the resolution is {frame.resolution} m, that of the map {self.resolution} m; use the same resolution'
            )
        row, column = round(frame.origin_y / self.resolution), round(frame.origin_x / self.resolution)
        for block_row, rows, frame_rows in _split_by_blocks(row, frame.rows):
            for block_column, columns, frame_columns in _split_by_blocks(column, frame.columns):
                yield (block_row, block_column), (rows, columns), (frame_rows, frame_columns)


def _split_by_blocks(first: int, count: int) -> Iterator[tuple[int, slice, slice]]:
    """Yield the blocks along one axis that overlap ``count`` cells from ``first``, with their cells."""
    for block in range(first // _BLOCK, (first + count - 1) // _BLOCK + 1):
        start, end = max(block * _BLOCK, first), min((block + 1) * _BLOCK, first + count)
        yield block, slice(start - block * _BLOCK, end - block * _BLOCK), slice(start - first, end - first)
