"""Route as CSV: one line ``x,y`` per cell, in the map frame [m]."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shirube_core.files import write_text


def save_route_table(path: Path, points_map: NDArray[np.float64]) -> None:
    """Write the points of a route [m], shape (n, 2), atomically.

    Raises:
        OSError: the file cannot be written.
    """
    lines = [f'{x:.4f},{y:.4f}\n' for x, y in points_map.tolist()]
    write_text(path, ''.join(['x,y\n', *lines]))
