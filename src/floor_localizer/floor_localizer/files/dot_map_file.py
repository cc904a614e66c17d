"""Reads and writes dot maps in either format, CSV or binary."""

import io
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np

from floor_localizer.core.arrays import Booleans, Floats
from floor_localizer.core.constellation.dot_grid import build_dot_grid, typical_spacing
from floor_localizer.core.constellation.indexed_map import IndexedMap, index_map
from floor_localizer.core.dots import DotMap
from floor_localizer.core.errors import DotMapError
from floor_localizer.files.binary_format import MAGIC, SUFFIX, BinaryMap, load_binary, save_binary
from shirube_core.files import atomic_write

MIN_DOTS = 20
# Maximum distance of duplicates; touching chips have centres a millimetre apart [m].
_SAME_PLACE = 1e-5
# Maximum plausible spacing: to see twenty such dots, a camera must be higher than any robot's belly [m].
_WIDEST_SPACING = 0.2
_LARGEST_DIAMETER = 0.1
# Maps in millimetres have values above these, maps in centimetres below.
_SPACING_IN_MILLIMETRES, _DIAMETER_IN_MILLIMETRES = 4.0, 0.8
HEADER = 'x,y,diameter'
_COLUMNS = HEADER.split(',')


def check_dot_map(dot_map: DotMap, source: str, locate: Callable[[int], str]) -> None:
    """Check that a map is a valid map of dots in metres; arguments as for `check_dots`.

    Raises:
        DotMapError: numbers that are not finite, diameters that are not positive, too few dots, duplicates, or a unit
            other than metres.
    """
    check_dot_count(len(dot_map), source)
    check_dots(dot_map.points, dot_map.diameters, source, locate)
    known = dot_map.diameters[np.isfinite(dot_map.diameters)]
    diameter = float(np.median(known)) if len(known) else 0.0
    check_units(diameter, typical_spacing(dot_map.points), source)
    duplicates = find_duplicates(dot_map.points, dot_map.points.min(axis=0))
    if duplicates is not None:
        raise DotMapError(
            f'{source}, {locate(duplicates[1])}: is the same dot as {locate(duplicates[0])}; leave one of the two out'
        )


def check_dot_count(dots: int, source: str) -> None:
    """Check that a map has enough dots."""
    if dots < MIN_DOTS:
        raise DotMapError(f'{source}: has {dots} dots, at least {MIN_DOTS} are needed; survey more of the floor')


def check_dots(points: Floats, diameters: Floats, source: str, locate: Callable[[int], str]) -> None:
    """Check each dot on its own: its coordinates and its diameter, NaN if unknown [m].

    ``locate`` returns the location of a dot in the file, such as ``line 7``.

    Raises:
        DotMapError: numbers that are not finite, diameters that are not positive.
    """
    for name, column in (('x', points[:, 0]), ('y', points[:, 1])):
        if not np.isfinite(column).all():
            where = locate(_first(~np.isfinite(column)))
            raise DotMapError(f'{source}, {where}: {name} is not finite; give metres or leave the dot out')
    wrong = (diameters <= 0.0) | np.isinf(diameters)
    if wrong.any():
        dot = _first(wrong)
        raise DotMapError(
            f'{source}, {locate(dot)}: diameter is {diameters[dot]:g}, it must be positive; '
            'leave it empty where it is unknown'
        )


def _first(mask: Booleans) -> int:
    return int(np.flatnonzero(mask)[0])


def check_units(diameter: float, spacing: float, source: str) -> None:
    """Check that a map is in metres, by the median diameter (0 if unknown) and the spacing of its dots [m]."""
    if diameter > _LARGEST_DIAMETER:
        sign, is_millimetres = f'diameters of {diameter:.3g} m', diameter > _DIAMETER_IN_MILLIMETRES
    elif spacing > _WIDEST_SPACING:
        sign, is_millimetres = f'dots {spacing:.3g} m apart', spacing > _SPACING_IN_MILLIMETRES
    else:
        return
    unit, divisor = ('millimetres', 1000) if is_millimetres else ('centimetres', 100)
    raise DotMapError(
        f'{source}: looks like {unit} ({sign}); x, y and diameter must be metres: divide them by {divisor}'
    )


def find_duplicates(points: Floats, lower: Floats) -> tuple[int, int] | None:
    """Return two dots at the same position, the earlier one first, or None; steps count from ``lower``."""
    steps = np.round((points - lower) / _SAME_PLACE).astype(np.int64)
    order = np.lexsort(steps.T)
    duplicates = (np.diff(steps[order], axis=0) == 0).all(axis=1)
    if not duplicates.any():
        return None
    earlier = _first(duplicates)
    return int(order[earlier]), int(order[earlier + 1])


def load_csv(path: Path) -> DotMap:
    """Load a map; raise a DotMapError for a file that is missing, malformed or no map of dots in metres."""
    lines = _read_lines(path)
    if not any(lines):
        raise DotMapError(f'{path}: is empty; write the header "{HEADER}" and one dot per line, in metres')
    _check_columns(path, lines[0])
    numbers = [number for number, line in enumerate(lines[1:], start=2) if line]
    table = parse_rows(path, [lines[number - 1] for number in numbers], numbers)
    dot_map = DotMap(np.ascontiguousarray(table[:, :2]), np.ascontiguousarray(table[:, 2]))
    check_dot_map(dot_map, str(path), lambda dot: f'line {numbers[dot]}')
    return dot_map


def save_csv(path: Path, dot_map: DotMap) -> None:
    """Write a map atomically, rounded to a micrometre; raises `DotMapError`."""
    try:
        with atomic_write(path) as file:
            file.write(f'{HEADER}\n'.encode())
            for (x, y), diameter in zip(dot_map.points, dot_map.diameters, strict=True):
                size = '' if math.isnan(diameter) else f'{diameter:.6f}'
                file.write(f'{x:.6f},{y:.6f},{size}\n'.encode())
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be written ({fault.strerror}); choose a writable place') from fault


def _read_lines(path: Path) -> list[str]:
    try:
        text = path.read_text(encoding='utf-8-sig')
    except OSError as fault:
        raise DotMapError(f'{path}: cannot be read ({fault.strerror}); give a dot map, CSV or .dotmap') from fault
    except UnicodeDecodeError as fault:
        raise DotMapError(f'{path}: is not a text file; give a CSV with the header "{HEADER}", or a .dotmap') from fault
    return [line.strip() for line in text.split('\n')]


def check_header(path: Path, head: bytes) -> None:
    """Check that a file's first line is the header of a dot map; the DotMapError quotes another one."""
    _check_columns(path, head.decode('utf-8-sig', 'replace').strip())


def _check_columns(path: Path, head: str) -> None:
    if [column.strip().lower() for column in head.split(',')] != _COLUMNS:
        raise DotMapError(
            f'{path}, line 1: the header is "{head[:40]}"; it must be "{HEADER}" (metres; diameter may be empty)'
        )


def parse_rows(path: Path, rows: list[str], numbers: list[int]) -> Floats:
    """Parse rows all at once, and one by one only to find the malformed one: x, y and diameter, shape (n, 3) [m].

    An empty diameter is NaN. ``numbers`` are the line numbers of the rows, which are not empty.

    Raises:
        DotMapError: a row is malformed.
    """
    if not rows:
        return np.empty((0, 3))
    filled = [row + 'nan' if row.endswith(',') else row for row in rows]
    try:
        table = np.loadtxt(io.StringIO('\n'.join(filled)), delimiter=',', comments=None, ndmin=2)
    except ValueError:
        table = np.empty((0, 0))
    if table.shape != (len(rows), 3) or 'nan' in '\n'.join(rows).lower():
        table = np.array([_parse_row(f'{path}, line {n}', row) for n, row in zip(numbers, rows, strict=True)])
    return table


def _parse_row(where: str, row: str) -> list[float]:
    """Return the three numbers of a row, NaN for an empty diameter, or raise a DotMapError."""
    fields = [field.strip() for field in row.split(',')]
    if len(fields) != len(_COLUMNS):
        raise DotMapError(f'{where}: has {len(fields)} fields instead of 3; write "{HEADER}"')
    values = []
    for name, field in zip(_COLUMNS, fields, strict=True):
        if name == 'diameter' and not field:
            values.append(math.nan)
            continue
        try:
            values.append(float(field))
        except ValueError as fault:
            raise DotMapError(f'{where}: {name} is "{field}", not a number; give metres') from fault
        if math.isnan(values[-1]):
            raise DotMapError(f'{where}: {name} is {field}, not finite; give metres or leave the dot out')
    return values


def load_indexed_map(path: Path) -> IndexedMap:
    """Load a map with its index: the binary format is memory-mapped, a CSV indexed (about a second)."""
    if _is_binary(path):
        return load_binary(path).floor
    return index_map(load_csv(path))


def load_dot_map(path: Path) -> DotMap:
    """Load the dots only; errors as `load_csv`."""
    if not _is_binary(path):
        return load_csv(path)
    return extract_dots(load_binary(path))


def load_dots_and_index(path: Path) -> tuple[DotMap, IndexedMap]:
    """Load the dots and the index, faster than with two calls; errors as `load_csv`."""
    dot_map = load_dot_map(path)
    return dot_map, load_binary(path).floor if _is_binary(path) else index_map(dot_map)


def write_indexed_map(path: Path, dot_map: DotMap, floor: IndexedMap) -> None:
    """Write a map and its index from `index_map` in the binary format, atomically; raises `DotMapError`."""
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
