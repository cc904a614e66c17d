"""Grid worlds from files: maps of the MovingAI benchmarks (movingai.com, Sturtevant 2012)."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError

_FREE_CELLS = frozenset('.GS')
_VALID_CELLS = _FREE_CELLS | frozenset('@OTW')


def load_movingai_map(path: Path) -> NDArray[np.bool_]:
    """Load a map: true where no robot can go; row 0 is the first line of the file. SceneError if it is none."""
    try:
        lines = path.read_text(encoding='ascii').splitlines()
    except OSError as error:
        raise SceneError(f'{path}: cannot be read ({error.strerror})') from error
    except UnicodeDecodeError as error:
        raise SceneError(f'{path}: not a text file; expected a MovingAI map') from error
    header = dict(line.split(maxsplit=1) for line in lines[:4] if len(line.split()) == 2)
    if lines[3:4] != ['map'] or not {'height', 'width'} <= set(header):
        raise SceneError(f'{path}: expected a MovingAI .map file that begins with type, height, width and map')
    try:
        rows, columns = int(header['height']), int(header['width'])
    except ValueError as error:
        raise SceneError(f'{path}: height and width must be whole numbers') from error
    cells = [line for line in lines[4:] if line]
    if len(cells) != rows or any(len(line) != columns for line in cells):
        raise SceneError(f'{path}: expected {rows} lines of {columns} cells, as in the header')
    unknown = sorted(set(''.join(cells)) - _VALID_CELLS)
    if unknown:
        raise SceneError(f'{path}: unknown cell {unknown[0]!r}; expected one of {"".join(sorted(_VALID_CELLS))}')
    return np.array([[cell not in _FREE_CELLS for cell in line] for line in cells])
