"""Occupancy grids: geometry in the map frame, cell values, and clearance from obstacles."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError

UNKNOWN = -1
FREE = 0
OCCUPIED = 100

OCCUPIED_THRESHOLD = 65  # map_server's default occupied_thresh, 0.65 [%]
FREE_THRESHOLD = 25  # map_server's default free_thresh, 0.25 [%]

_ROUNDING = 1e-4  # distances are computed in single precision [cells]
_CELL_MAX = 2.0**40  # cell indices are clipped here; such cells are outside of every map


@dataclass(frozen=True)
class GridFrame:
    """Geometry of a grid along x and y of the map; row 0 has the smallest y, as in OccupancyGrid.

    Attributes:
        origin_x: x of the lower left corner of cell (0, 0) [m].
        origin_y: y of the lower left corner of cell (0, 0) [m].
        resolution: side of a cell [m].
        columns: number of cells along x.
        rows: number of cells along y.

    Raises:
        RewardPlannerError: the resolution is not above 0, a number is not finite, or the grid is empty.
    """

    origin_x: float
    origin_y: float
    resolution: float
    columns: int
    rows: int

    def __post_init__(self) -> None:
        if not (math.isfinite(self.resolution) and self.resolution > 0.0):
            raise RewardPlannerError(f'resolution is {self.resolution} m, it must be above 0')
        if not (math.isfinite(self.origin_x) and math.isfinite(self.origin_y)):
            raise RewardPlannerError(f'origin is {self.origin_x}, {self.origin_y}, it must be two finite numbers')
        if self.columns < 1 or self.rows < 1:
            raise RewardPlannerError(f'the grid has {self.columns} x {self.rows} cells, it must have at least one')

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, the shape of an array over the grid."""
        return self.rows, self.columns

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.rows * self.columns

    @property
    def corners(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest corner, x and y [m], shape (2,) each."""
        low = np.array([self.origin_x, self.origin_y])
        return low, low + self.resolution * np.array([self.columns, self.rows])

    def cell_of(self, xy: ArrayLike) -> NDArray[np.int64]:
        """Return rows and columns of points in the map frame [m], both of shape (..., 2).

        Points outside of the grid get cells outside of it.

        Raises:
            RewardPlannerError: a coordinate is not finite.
        """
        points = np.asarray(xy, dtype=np.float64)
        if not np.isfinite(points).all():
            raise RewardPlannerError('a point has a coordinate that is not finite; give x and y in metres')
        cells = np.floor((points - (self.origin_x, self.origin_y)) / self.resolution)
        return np.clip(cells[..., ::-1], -_CELL_MAX, _CELL_MAX).astype(np.int64)

    def centre_of(self, cells: ArrayLike) -> NDArray[np.float64]:
        """Return the centres of cells (rows and columns) in the map frame [m], both of shape (..., 2)."""
        column_row = np.asarray(cells, dtype=np.float64)[..., ::-1]
        return (column_row + 0.5) * self.resolution + (self.origin_x, self.origin_y)

    def contains(self, cells: ArrayLike) -> NDArray[np.bool_]:
        """Return which cells are inside of the grid: shape (...) for cells of shape (..., 2)."""
        inside = np.asarray(cells)
        return np.asarray(((inside >= 0) & (inside < self.shape)).all(axis=-1))


@dataclass(frozen=True)
class OccupancyMap:
    """An occupancy grid.

    Attributes:
        frame: origin, resolution and size of the grid.
        occupancy: probability of occupancy, 0 to 100 %, -1 for unknown; int8, shape (rows, columns).

    Raises:
        RewardPlannerError: the shapes of array and frame differ.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]

    def __post_init__(self) -> None:
        if self.occupancy.shape != self.frame.shape:
            raise RewardPlannerError(
                f'the map has {self.occupancy.shape} rows and columns, its frame {self.frame.shape}; they must be equal'
            )

    def occupied(self) -> NDArray[np.bool_]:
        """Return the occupied cells, shape (rows, columns); unknown cells are not occupied."""
        return self.occupancy >= OCCUPIED_THRESHOLD


def resample_map(grid: OccupancyMap, frame: GridFrame) -> NDArray[np.int8]:
    """Return a map's values in the cells of a frame, `UNKNOWN` outside of the map, shape (rows, columns).

    A cell gets the value at its centre, or the greatest value of the map's cells whose centres are in it.
    """
    values = np.full(frame.shape, UNKNOWN, dtype=np.int8)
    row_centres = frame.centre_of(np.stack([np.arange(frame.rows), np.zeros(frame.rows)], axis=1))
    column_centres = frame.centre_of(np.stack([np.zeros(frame.columns), np.arange(frame.columns)], axis=1))
    rows, columns = grid.frame.cell_of(row_centres)[:, 0], grid.frame.cell_of(column_centres)[:, 1]
    has_row = (rows >= 0) & (rows < grid.frame.rows)
    has_column = (columns >= 0) & (columns < grid.frame.columns)
    values[np.ix_(has_row, has_column)] = grid.occupancy[np.ix_(rows[has_row], columns[has_column])]
    _raise_to(values, frame, grid.frame.centre_of(np.argwhere(grid.occupancy > FREE)), grid)
    return values


def turned_map(cells: NDArray[np.int8], resolution: float, origin: tuple[float, float, float]) -> OccupancyMap:
    """Return a map along x and y from one whose lower left corner has the pose x, y [m], yaw [rad].

    Cells have the value at their centres, or the greatest one of the given cells whose centres are in them, so that
    thin walls stay closed. The frame's corner is at a multiple of the resolution.
    """
    rows, columns = cells.shape
    grid = OccupancyMap(GridFrame(0.0, 0.0, resolution, columns, rows), cells)
    x, y, yaw = origin
    turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])  # grid to map, transposed
    low, high = grid.frame.corners
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])]) @ turn + (x, y)
    first = np.floor(corners.min(axis=0) / resolution + _ROUNDING)
    count = np.ceil(corners.max(axis=0) / resolution - _ROUNDING) - first
    low_x, low_y = (first * resolution).tolist()
    frame = GridFrame(low_x, low_y, resolution, int(count[0]), int(count[1]))
    centres = frame.centre_of(np.argwhere(np.ones(frame.shape, dtype=np.bool_)))
    at = grid.frame.cell_of((centres - (x, y)) @ turn.T)
    inside = grid.frame.contains(at)
    values = np.full(frame.size, UNKNOWN, dtype=np.int8)
    values[inside] = cells[tuple(at[inside].T)]
    values = values.reshape(frame.shape)
    _raise_to(values, frame, grid.frame.centre_of(np.argwhere(cells > FREE)) @ turn + (x, y), grid)
    return OccupancyMap(frame, values)


def _raise_to(values: NDArray[np.int8], frame: GridFrame, places: NDArray[np.float64], grid: OccupancyMap) -> None:
    """Raise values in a frame to those of a map's cells above 0, whose places in the frame [m] are given in order."""
    cells = frame.cell_of(places)
    inside = frame.contains(cells)
    np.maximum.at(values, tuple(cells[inside].T), grid.occupancy[grid.occupancy > FREE][inside])


def clearance(occupied: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """Return the distance from each cell's centre to that of the nearest occupied one [m], infinite without one.

    Args:
        occupied: occupied cells, shape (rows, columns) as the result.
        resolution: side of a cell [m].
    """
    if not occupied.any():
        return np.full(occupied.shape, np.inf, dtype=np.float32)
    free = np.logical_not(occupied).astype(np.uint8)
    distances = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(distances * np.float32(resolution), dtype=np.float32)
