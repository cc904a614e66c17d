"""A dot map with its search index, and the paper's matching address matrix (2.3.3) as an occupancy bitmap."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from floor_localizer.core.arrays import Pixels
from floor_localizer.core.constellation.constellation_index import ConstellationIndex, build_constellation_index
from floor_localizer.core.constellation.dot_grid import DotGrid, build_dot_grid, pair_density
from floor_localizer.core.constellation.index_format import LARGE_MAP
from floor_localizer.core.dots import DotMap, Level

# Maximum distance of a dot from the centre of an occupied block, and side of a block [mean dot spacings].
_OCCUPIED_RADIUS, _BLOCK_SIZE = 0.15, 0.06


class OccupancyBitmap(NamedTuple):
    """Blocks of the floor that are occupied by a dot.

    Attributes:
        bits: shape (rows, columns / 8) uint8, one bit per block.
        x0: lower edge of the first column [m].
        y0: lower edge of the first row [m].
        block: side of a block [m].
    """

    bits: Pixels
    x0: float
    y0: float
    block: float


@njit(cache=True)
def bitmap_shape(rows: int, columns: int) -> tuple[int, int]:
    """Return the shape of the bits for a grid with these numbers of rows and columns of cells."""
    return math.ceil(rows / _BLOCK_SIZE) + 8, (math.ceil(columns / _BLOCK_SIZE) + 8) // 8 + 1


@njit(cache=True)
def build_occupancy_bitmap(grid: DotGrid) -> OccupancyBitmap:
    """Mark the blocks whose centres are close to a dot."""
    block, radius = _BLOCK_SIZE * grid.cell, _OCCUPIED_RADIUS * grid.cell
    bits = np.zeros(bitmap_shape(grid.rows, grid.columns), dtype=np.uint8)
    rows, columns = bits.shape[0], 8 * bits.shape[1]
    margin = 4 * block
    x0, y0 = grid.x0 - margin, grid.y0 - margin
    steps = int(radius / block) + 1
    for i in range(len(grid.points)):
        column = int((grid.points[i, 0] - x0) / block)
        row = int((grid.points[i, 1] - y0) / block)
        for r in range(max(row - steps, 0), min(row + steps + 1, rows)):
            for c in range(max(column - steps, 0), min(column + steps + 1, columns)):
                dx = x0 + (c + 0.5) * block - grid.points[i, 0]
                dy = y0 + (r + 0.5) * block - grid.points[i, 1]
                if dx * dx + dy * dy <= radius * radius:
                    bits[r, c >> 3] |= np.uint8(1 << (c & 7))
    return OccupancyBitmap(bits, x0, y0, block)


@njit(cache=True)
def is_occupied(bitmap: OccupancyBitmap, x: float, y: float) -> bool:
    """Return whether there is a map dot at a position of the map [m]: ten times faster than a nearest-dot query."""
    column = int((x - bitmap.x0) / bitmap.block)
    row = int((y - bitmap.y0) / bitmap.block)
    if row < 0 or column < 0 or row >= bitmap.bits.shape[0] or column >= bitmap.bits.shape[1] * 8:
        return False
    return (bitmap.bits[row, column >> 3] >> (column & 7)) & 1 == 1


@dataclass(frozen=True)
class IndexedMap:
    """A map and everything that the search needs.

    Attributes:
        grid: spatial hash of the dots.
        index: geometric hash table of their constellations.
        addresses: occupancy bitmap (the paper's matching address matrix), empty for a large map (`LARGE_MAP`).
        density: density of the dots on the occupied floor [1/m^2].
        levels: floor levels of the map; none for a map of a single floor.
    """

    grid: DotGrid
    index: ConstellationIndex
    addresses: OccupancyBitmap
    density: float
    levels: tuple[Level, ...] = ()


def index_map(dot_map: DotMap) -> IndexedMap:
    """Index a map for the search; the paper's 91 582 dots take about a second."""
    grid, _ = build_dot_grid(dot_map.points)
    return IndexedMap(grid, build_constellation_index(grid), build_map_occupancy(grid), pair_density(grid))


def build_map_occupancy(grid: DotGrid) -> OccupancyBitmap:
    """Return the occupancy bitmap of a map; empty for a large map, which is not searched by pairs."""
    if len(grid.points) > LARGE_MAP:
        addresses = OccupancyBitmap(np.zeros((0, 0), dtype=np.uint8), grid.x0, grid.y0, grid.cell)
    else:
        addresses = build_occupancy_bitmap(grid)
    addresses.bits.flags.writeable = False  # as in a file, so that numba compiles the search only once
    return addresses
