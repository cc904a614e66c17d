"""Grid worlds from files: maps and scenarios of the MovingAI benchmarks (movingai.com, Sturtevant 2012)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError

_FREE_CELLS = frozenset('.GS')
_VALID_CELLS = _FREE_CELLS | frozenset('@OTW')


@dataclass(frozen=True)
class Scenario:
    """One task of a scenario file.

    Attributes:
        start: row and column.
        goal: row and column.
        length: length of the shortest path, diagonal steps sqrt(2), no corner cutting [cells].
    """

    start: tuple[int, int]
    goal: tuple[int, int]
    length: float


def load_movingai_map(path: Path) -> NDArray[np.bool_]:
    """Load a map: true where no robot can go; row 0 is the first line of the file. SceneError if it is none."""
    lines = _read_lines(path)
    header = dict(line.split(maxsplit=1) for line in lines[:4] if len(line.split()) == 2)
    if lines[3:4] != ['map'] or not {'height', 'width'} <= set(header):
        raise SceneError(
            f'{path}: expected a MovingAI .map file that begins with type, height, width and map'
        )
    try:
        rows, columns = int(header['height']), int(header['width'])
    except ValueError as error:
        raise SceneError(f'{path}: height and width must be whole numbers') from error
    cells = [line for line in lines[4:] if line]
    if len(cells) != rows or any(len(line) != columns for line in cells):
        raise SceneError(f'{path}: expected {rows} lines of {columns} cells, as in the header')
    unknown = sorted(set(''.join(cells)) - _VALID_CELLS)
    if unknown:
        raise SceneError(
            f'{path}: unknown cell {unknown[0]!r}; expected one of {"".join(sorted(_VALID_CELLS))}'
        )
    return np.array([[cell not in _FREE_CELLS for cell in line] for line in cells])


def load_movingai_scenarios(path: Path) -> list[Scenario]:
    """Load a scenario file, or raise SceneError with the line."""
    scenarios = []
    for number, line in enumerate(_read_lines(path), start=1):
        fields = line.split()
        if not fields or fields[0] == 'version':
            continue
        try:
            column, row, goal_column, goal_row = (int(field) for field in fields[4:8])
            scenarios.append(Scenario((row, column), (goal_row, goal_column), float(fields[8])))
        except (ValueError, IndexError) as error:
            raise SceneError(
                f'{path}: line {number} is not a scenario; expected bucket, map, size, start, goal and length'
            ) from error
    return scenarios


def _read_lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding='ascii').splitlines()
    except OSError as error:
        raise SceneError(f'{path}: cannot be read ({error.strerror})') from error
    except UnicodeDecodeError as error:
        raise SceneError(f'{path}: not a text file; expected a MovingAI map or scenario') from error
