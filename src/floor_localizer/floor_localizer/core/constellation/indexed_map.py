"""A dot map with its search index."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from floor_localizer.core.constellation.constellation_index import (
    ConstellationIndex,
    build_constellation_index,
)
from floor_localizer.core.constellation.dot_grid import DotGrid, build_dot_grid, pair_density
from floor_localizer.core.constellation.index_rules import LARGE_MAP
from floor_localizer.core.constellation.occupancy_bitmap import OccupancyBitmap, build_occupancy_bitmap
from floor_localizer.core.dot_map import DotMap
from floor_localizer.core.levels import Level


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
