"""Statistics of a dot map: number, density and size of the dots, and size of the index."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.constellation.dot_grid import typical_spacing
from floor_localizer.core.constellation.indexed_map import IndexedMap
from floor_localizer.core.dot_map import DotMap


@dataclass(frozen=True)
class MapStatistics:
    """Statistics of a map.

    Attributes:
        dots: number of dots.
        lower: shape (2,), lower left corner of the dots' bounding box [m].
        upper: shape (2,), upper right corner [m].
        area: area of the occupied floor, without gaps between rooms [m^2].
        density: density of dots in that area [1/m^2].
        diameters: shape (3,), smallest, median and largest known diameter [m]; None if none is known.
        known_diameter_fraction: fraction of the dots with a known diameter.
        constellations: number of constellations in the index.
        bytes_per_dot: size of dots and index, in memory and in the binary format, per dot [bytes].
    """

    dots: int
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    area: float
    density: float
    diameters: NDArray[np.float64] | None
    known_diameter_fraction: float
    constellations: int
    bytes_per_dot: float


def compute_map_statistics(dot_map: DotMap, floor: IndexedMap) -> MapStatistics:
    """Return the statistics of a map.

    Args:
        dot_map: the dots.
        floor: the same map with its index.
    """
    density = 1.0 / typical_spacing(dot_map.points) ** 2
    known = dot_map.diameters[np.isfinite(dot_map.diameters)]
    arrays = (
        *(floor.grid.points, floor.grid.starts, floor.addresses.bits),
        *(floor.index.entries, floor.index.starts),
    )
    return MapStatistics(
        dots=len(dot_map),
        lower=dot_map.points.min(axis=0),
        upper=dot_map.points.max(axis=0),
        area=len(dot_map) / density,
        density=density,
        diameters=np.percentile(known, [0.0, 50.0, 100.0]) if len(known) else None,
        known_diameter_fraction=len(known) / len(dot_map),
        constellations=len(floor.index.entries),
        bytes_per_dot=sum(array.nbytes for array in arrays) / len(dot_map),
    )
