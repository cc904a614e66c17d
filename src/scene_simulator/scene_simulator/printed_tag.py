"""A printed square tag on the ceiling, as marker detectors look for, lit by the room."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from scene_simulator.ceiling_lamp import CeilingLamp
from scene_simulator.errors import SceneError
from scene_simulator.lamp_shape import Rectangle
from shirube_core.geometry import matrix_from_rpy


def printed_tag(
    cells: ArrayLike, cell: float, xyz: tuple[float, float, float], brightness: float, yaw: float = 0.0
) -> tuple[CeilingLamp, ...]:
    """Return the white parts of a tag as steady lights; its black parts send nothing.

    Photograph it with a lens without glow (``SHARP``): then neighbouring parts join without a seam.

    Args:
        cells: array-like, shape (rows, columns), true for white, as the tag is seen from below with its upper edge
            towards the face's x; the white margin that detectors need belongs to it.
        cell: width of a cell [m].
        xyz: middle of the tag in the map frame [m].
        brightness: brightness of white paper, in full wells per second of exposure [1/s].
        yaw: yaw of the tag's face in the map frame [rad].

    Raises:
        SceneError: cells of another shape, or a width that is not positive.
    """
    white = np.asarray(cells, dtype=np.bool_)
    if white.ndim != 2 or white.size == 0 or not 0.0 < cell < float('inf'):
        raise SceneError(
            f'a tag has rows x columns of cells of a positive width, not {white.shape} of {cell} m'
        )
    rows, columns = white.shape
    axes = matrix_from_rpy((0.0, 0.0, yaw))
    parts = []
    for row, line in enumerate(white):
        ends = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
        for start, stop in ends.reshape(-1, 2).tolist():
            middle = cell * np.array([0.5 * (rows - 1) - row, 0.5 * (start + stop - columns), 0.0])
            x, y, z = (np.array(xyz) + axes @ middle).tolist()
            shape = Rectangle(cell, cell * (stop - start))
            parts.append(CeilingLamp((x, y, z), shape, brightness=brightness, rpy=(0.0, 0.0, yaw)))
    return tuple(parts)
