"""What a frame adds to the values of voxels."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.voxels.frame_window import TILE, FrameWindow, place_of_cell

_NEARLY_MAXIMUM = 0.99


def counts_over_maximum(counts: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return V = count / M, shape (k,), at most 1 (2.2.2, eq. 3).

    The paper says that M is "about the maximum of the counts of all voxels": here the count that 1 % of the frame's
    voxels with points exceed, so that a single odd voxel does not rule over the others.

    Args:
        counts: shape (k,), of the voxels that have points.
    """
    if len(counts) == 0:
        return np.empty(0, dtype=np.float32)
    nearly_all = min(int(_NEARLY_MAXIMUM * len(counts)), len(counts) - 1)
    M = np.partition(counts, nearly_all)[nearly_all]
    return np.minimum(counts / M, 1.0).astype(np.float32)


def counts_over_expected(counts: NDArray[np.int32], expected: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return count / (f s / Z)^2, shape (k,), at most 1: the same for near and far voxels that are equally full.

    Args:
        counts: shape (k,), of the voxels that have points.
        expected: shape (k,), of a surface across the voxel; 0 gives the value 1.
    """
    return np.minimum(counts / np.maximum(expected, 1.0), 1.0).astype(np.float32)


@njit(cache=True)
def touched_tiles(window: FrameWindow, cells: NDArray[np.int32], touched: NDArray[np.bool_]) -> None:
    """Note in which tiles of the window cells lie.

    Args:
        window: the box of voxels.
        cells: shape (k,), flat indices in it.
        touched: shape (tiles, tiles) along x and y; becomes true.
    """
    for cell in cells:
        column, row, _ = place_of_cell(cell, window.side, window.layers)
        touched[column // TILE, row // TILE] = True


@njit(cache=True)
def add_to_voxels(
    values: NDArray[np.float32],
    slots: NDArray[np.int64],
    window: FrameWindow,
    cells: NDArray[np.int32],
    amounts: NDArray[np.float32],
    limits: tuple[float, float],
) -> None:
    """Add to the values of voxels within limits.

    Args:
        values: shape (slots, TILE, TILE, layers).
        slots: shape (tiles, tiles), of the window's tiles; those of the cells exist.
        window: the box of voxels.
        cells: shape (k,), flat indices in it.
        amounts: shape (k,), or (1,) if it is the same for all.
        limits: lowest and highest value.
    """
    same = len(amounts) == 1
    for i, cell in enumerate(cells):
        column, row, layer = place_of_cell(cell, window.side, window.layers)
        slot = slots[column // TILE, row // TILE]
        value = values[slot, column % TILE, row % TILE, layer] + amounts[0 if same else i]
        values[slot, column % TILE, row % TILE, layer] = min(max(value, limits[0]), limits[1])
