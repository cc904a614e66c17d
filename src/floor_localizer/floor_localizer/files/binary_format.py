"""The dot map in the suite's binary format: dots and index, memory-mapped instead of read.

The file begins with a magic number, then version, length and checksum of a header, then the header as JSON,
then the arrays, little-endian, each aligned to 64 bytes:

    magic 8 bytes | version uint32 | header length uint32 | CRC-32 of the header uint32 | header | arrays

The header contains the size of the file, the scalars of the grids, the parameters of the index, and type, shape and
offset of each array. Points are float32: their rounding error is half a micrometre at ten metres from the origin, and
four micrometres at a hundred metres.
"""

import json
import math
import mmap
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.arrays import Float32s, Pixels
from floor_localizer.core.constellation import constellation_key, index_format
from floor_localizer.core.constellation.constellation_index import ConstellationIndex
from floor_localizer.core.constellation.dot_grid import DotGrid
from floor_localizer.core.constellation.indexed_map import IndexedMap, OccupancyBitmap
from floor_localizer.core.dots import Level
from floor_localizer.core.errors import DotMapError
from shirube_core.files import atomic_write

SUFFIX = '.dotmap'
MAGIC = b'\x89DOTMAP\n'
VERSION = 3
_PREFIX = struct.Struct('<8sIII')
_ALIGNMENT = 64
HEADER_SIZE = 1 << 16  # size of prefix and header, the offset of the first array [bytes]
_REMEDY = 'write it again from its CSV with "inspect_map MAP.csv --write MAP.dotmap"'
# The index must have been built with the parameters of the search, otherwise nothing would be found.
_RULES = {
    'lower': list(constellation_key.LOWER),
    'lanes': constellation_key.COORDINATE_HASHES.tolist(),
    'parts': constellation_key.STEPS_PER_CELL,
    'dot_bits': index_format.DOT_BITS,
}
_PARTS: dict[str, Any] = {'grid': DotGrid, 'index': ConstellationIndex, 'addresses': OccupancyBitmap}
TYPES = {
    'diameters': '<f4',
    'grid.points': '<f4',
    'grid.starts': '<u4',
    'addresses.bits': '|u1',
    'index.starts': '<u4',
    'index.entries': '<u8',
}
"""Type of each array, in the order of the file."""


@dataclass(frozen=True)
class BinaryMap:
    """Dots with their index, and diameters in the order of the grid, (N,) float32 [m] or NaN; (0,) if all unknown."""

    floor: IndexedMap
    diameters: Float32s


def save_binary(path: Path, binary_map: BinaryMap) -> None:
    """Write a map atomically; raises `DotMapError`."""
    values = _values_of(binary_map)
    arrays = {name: np.ascontiguousarray(values[name], dtype) for name, dtype in TYPES.items()}
    locations = array_locations({name: array.shape for name, array in arrays.items()})
    try:
        with atomic_write(path) as file:
            file.write(header_bytes(path, locations, binary_map))
            for name, array in arrays.items():
                file.seek(locations[name].offset)
                file.write(array.tobytes())
            file.truncate(file_size(locations))
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be written ({fault.strerror}); choose a writable place') from fault


@dataclass(frozen=True)
class ArrayLocation:
    """Type, shape and offset [bytes] of an array in the file."""

    dtype: str
    shape: tuple[int, ...]
    offset: int

    @property
    def bytes(self) -> int:
        """Size of the array [bytes]."""
        return math.prod(self.shape) * np.dtype(self.dtype).itemsize


def array_locations(shapes: Mapping[str, tuple[int, ...]]) -> dict[str, ArrayLocation]:
    """Return the locations of arrays with these shapes; no location depends on the size of the last array."""
    locations, end = {}, HEADER_SIZE
    for name, dtype in TYPES.items():
        locations[name] = ArrayLocation(dtype, tuple(shapes[name]), end)
        end = _aligned(end + locations[name].bytes)
    return locations


def file_size(locations: Mapping[str, ArrayLocation]) -> int:
    """Return the size of the file [bytes]."""
    return _aligned(max(location.offset + location.bytes for location in locations.values()))


def header_bytes(path: Path, locations: Mapping[str, ArrayLocation], binary_map: BinaryMap) -> bytes:
    """Return prefix and header of a map's file; raise a DotMapError if the names of its levels are too long."""
    header = {
        'rules': _RULES,
        'numbers': {name: value for name, value in _values_of(binary_map).items() if name not in TYPES},
        'arrays': {
            name: {'dtype': location.dtype, 'shape': location.shape, 'offset': location.offset}
            for name, location in locations.items()
        },
        'size': file_size(locations),
    }
    text = json.dumps(header).encode()
    if len(text) > HEADER_SIZE - _PREFIX.size:
        raise DotMapError(f'{path}: the names of the levels are too long; shorten them')
    text = text.ljust(HEADER_SIZE - _PREFIX.size)
    return _PREFIX.pack(MAGIC, VERSION, len(text), zlib.crc32(text)) + text


def load_binary(path: Path) -> BinaryMap:
    """Open a map with read-only, memory-mapped arrays; raise a DotMapError for any file that is not one."""
    try:
        if path.stat().st_size < _PREFIX.size:
            raise DotMapError(f'{path}: is empty or truncated; {_REMEDY}')
        content = memory_map(path)
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be read ({fault.strerror}); give a dot map, CSV or {SUFFIX}') from fault
    header = _read_header(path, content)
    try:
        locations = {name: _array_location(header, name) for name in TYPES}
        values = {name: view_array(content, location) for name, location in locations.items()}
        binary_map = _assemble(values | header['numbers'])
        _check_sizes(binary_map)
    except (KeyError, TypeError, ValueError) as fault:
        raise DotMapError(f'{path}: is corrupted, its header contradicts its content; {_REMEDY}') from fault
    return binary_map


def memory_map(path: Path) -> Pixels:
    """Return the memory-mapped bytes of a file; the array keeps the mapping alive.

    A search reads single pages all over the file: read-ahead, up to megabytes per page, would load the whole file.

    Raises:
        OSError: the file cannot be read.
    """
    with path.open('rb') as file:
        mapping = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    mapping.madvise(mmap.MADV_RANDOM)
    return np.frombuffer(mapping, dtype=np.uint8)


def _aligned(location: int) -> int:
    return -(-location // _ALIGNMENT) * _ALIGNMENT


def _values_of(binary_map: BinaryMap) -> dict[str, Any]:
    """Return all arrays and scalars of a map by their names in the file."""
    floor = binary_map.floor
    levels = [[level.name, level.offset, level.lower, level.upper] for level in floor.levels]
    values: dict[str, Any] = {'diameters': binary_map.diameters, 'density': floor.density, 'sheets': levels}
    for part in _PARTS:
        values |= {f'{part}.{name}': value for name, value in getattr(floor, part)._asdict().items()}
    return values


def _assemble(values: dict[str, Any]) -> BinaryMap:
    parts = {part: kind(**{name: values[f'{part}.{name}'] for name in kind._fields}) for part, kind in _PARTS.items()}
    levels = tuple(Level(name, *(tuple(location) for location in locations)) for name, *locations in values['sheets'])
    return BinaryMap(IndexedMap(**parts, density=values['density'], levels=levels), values['diameters'])


def _read_header(path: Path, content: Pixels) -> dict[str, Any]:
    """Return the header of a complete file of this version."""
    magic, version, length, checksum = _PREFIX.unpack(content[: _PREFIX.size].tobytes())
    if magic != MAGIC:
        raise DotMapError(f'{path}: is not a dot map; give a {SUFFIX} that inspect_map wrote, or a CSV')
    if version != VERSION:
        raise DotMapError(f'{path}: has version {version}, this program reads version {VERSION}; {_REMEDY}')
    text = content[_PREFIX.size : _PREFIX.size + length].tobytes()
    if len(text) < length:
        raise DotMapError(f'{path}: is truncated; {_REMEDY}')
    if zlib.crc32(text) != checksum:
        raise DotMapError(f'{path}: is corrupted, the checksum of its header is wrong; {_REMEDY}')
    header: dict[str, Any] = json.loads(text)
    if header['rules'] != _RULES:
        raise DotMapError(f'{path}: has an index from another version of this program; {_REMEDY}')
    if len(content) < header['size']:
        raise DotMapError(f'{path}: is truncated ({len(content)} of {header["size"]} bytes); {_REMEDY}')
    return header


def _array_location(header: dict[str, Any], name: str) -> ArrayLocation:
    location = ArrayLocation(**header['arrays'][name])
    if location.dtype != TYPES[name]:
        raise ValueError(location.dtype)
    return location


def view_array(content: Pixels, location: ArrayLocation) -> NDArray[Any]:
    """Return a view of one array in the content of a file."""
    part = content[location.offset : location.offset + location.bytes]
    return part.view(location.dtype).reshape(location.shape)


def _check_sizes(binary_map: BinaryMap) -> None:
    """Check that the sizes of the arrays are consistent, because the search does not check bounds."""
    grid, index, addresses = binary_map.floor.grid, binary_map.floor.index, binary_map.floor.addresses
    dots, constellations = len(grid.points), len(index.entries)
    fits = (
        grid.points.shape == (dots, 2)
        and binary_map.diameters.shape in {(dots,), (0,)}
        and grid.starts.shape == (grid.rows * grid.columns + 1,)
        and grid.starts[-1] == dots
        and len(index.starts) > 1
        and index.starts[-1] == constellations
        and min(index.step, index.longest) > 0.0
        and addresses.bits.ndim == 2
        and min(grid.cell, addresses.block, binary_map.floor.density) > 0.0
    )
    if not fits:
        raise ValueError('sizes')
