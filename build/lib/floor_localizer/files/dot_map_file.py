"""Reads and writes dot maps in either format, CSV or binary."""

from pathlib import Path

import numpy as np

from floor_localizer.core.constellation.dot_grid import build_dot_grid
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.files.binary_format import MAGIC, SUFFIX, BinaryMap, load_binary, save_binary
from floor_localizer.files.csv_format import load_csv


def load_indexed_map(path: Path) -> IndexedMap:
    """Load a map with its index: the binary format is memory-mapped, a CSV is indexed (about a second).

    Raises:
        DotMapError: a file that is missing, malformed or no map of dots in metres.
    """
    if _is_binary(path):
        return load_binary(path).floor
    return index_map(load_csv(path))


def load_dot_map(path: Path) -> DotMap:
    """Load the dots only.

    Raises:
        DotMapError: a file that is missing, malformed or no map of dots in metres.
    """
    if not _is_binary(path):
        return load_csv(path)
    return extract_dots(load_binary(path))


def load_dots_and_index(path: Path) -> tuple[DotMap, IndexedMap]:
    """Load the dots and the index, faster than with two calls.

    Raises:
        DotMapError: a file that is missing, malformed or no map of dots in metres.
    """
    dot_map = load_dot_map(path)
    return dot_map, load_binary(path).floor if _is_binary(path) else index_map(dot_map)


def write_indexed_map(path: Path, dot_map: DotMap, floor: IndexedMap) -> None:
    """Write a map, with its index from `index_map`, in the binary format, atomically.

    Raises:
        DotMapError: the file cannot be written.
    """
    _, order = build_dot_grid(dot_map.points)
    diameters = dot_map.diameters[order].astype(np.float32)
    save_binary(path, BinaryMap(floor, diameters if np.isfinite(diameters).any() else diameters[:0]))


def extract_dots(binary_map: BinaryMap) -> DotMap:
    """Return the dots of a map in the order of its grid."""
    points = binary_map.floor.grid.points.astype(np.float64)
    diameters = binary_map.diameters.astype(np.float64)
    return DotMap(points, diameters if len(diameters) else np.full(len(points), np.nan))


def _is_binary(path: Path) -> bool:
    """Return whether a file is in the binary format, from its suffix or its first bytes."""
    if path.suffix == SUFFIX:
        return True
    try:
        with path.open('rb') as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False
