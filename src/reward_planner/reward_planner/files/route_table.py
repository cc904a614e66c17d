"""A route as a CSV: one line a cell, ``x,y`` in metres in the map frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_files import write_text


def save_route_table(path: Path, points_map: NDArray[np.float64]) -> None:
    """Write the points of a route, shape (n, 2) [m]; the file is whole or not there.

    Raises:
        OSError: the place cannot be written to.
    """
    lines = [f'{x:.4f},{y:.4f}\n' for x, y in points_map.tolist()]
    write_text(path, ''.join(['x,y\n', *lines]))
