"""The dot map as CSV: the header ``x,y,diameter``, then one dot per line, in metres; diameter may be empty."""

from __future__ import annotations

import io
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_map import DotMap
from floor_localizer.files.dot_map_check import check_dot_map
from floor_localizer.files.file_errors import DotMapError
from shirube_core.files import atomic_write

HEADER = 'x,y,diameter'
_COLUMNS = HEADER.split(',')


def load_csv(path: Path) -> DotMap:
    """Load a map.

    Raises:
        DotMapError: a file that is missing, empty, malformed or no map of dots in metres.
    """
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
    """Write a map atomically, rounded to a micrometre.

    Raises:
        DotMapError: the file cannot be written.
    """
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
        raise DotMapError(
            f'{path}: cannot be read ({fault.strerror}); give a dot map, CSV or .dotmap'
        ) from fault
    except UnicodeDecodeError as fault:
        raise DotMapError(
            f'{path}: is not a text file; give a CSV with the header "{HEADER}", or a .dotmap'
        ) from fault
    return [line.strip() for line in text.split('\n')]


def check_header(path: Path, head: bytes) -> None:
    """Check that the first line of a file is the header of a dot map.

    Raises:
        DotMapError: another header, which the message quotes.
    """
    _check_columns(path, head.decode('utf-8-sig', 'replace').strip())


def _check_columns(path: Path, head: str) -> None:
    if [column.strip().lower() for column in head.split(',')] != _COLUMNS:
        raise DotMapError(
            f'{path}, line 1: the header is "{head[:40]}"; it must be "{HEADER}" '
            '(metres; diameter may be empty)'
        )


def parse_rows(path: Path, rows: list[str], numbers: list[int]) -> NDArray[np.float64]:
    """Parse rows all at once, and one by one only to find the malformed one.

    Args:
        path: path of the file, for the message.
        rows: nonempty rows.
        numbers: line number of each row in the file.

    Returns:
        x, y and diameter, shape (n, 3) [m], NaN for an empty diameter.

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
