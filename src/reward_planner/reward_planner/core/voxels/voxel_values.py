"""Voxel values of one frame, and their addition to the map."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.voxels.frame_window import TILE_SIZE, FrameWindow, unravel_cell

_MAXIMUM_QUANTILE = 0.99


def counts_over_maximum(counts: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return V = count / M, shape (k,), at most 1 (2.2.2, eq. 3).

    The paper defines M as "about the maximum of the counts of all voxels". Here it is the 99 % quantile of the frame's
    voxels with points, so that a single outlier does not scale all others.

    Args:
        counts: points of each voxel with points, shape (k,).
    """
    if len(counts) == 0:
        return np.empty(0, dtype=np.float32)
    index = min(int(_MAXIMUM_QUANTILE * len(counts)), len(counts) - 1)
    M = np.partition(counts, index)[index]
    return np.minimum(counts / M, 1.0).astype(np.float32)


def counts_over_expected(counts: NDArray[np.int32], expected: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return count / (f s / Z)^2, shape (k,), at most 1: independent of the voxel's range.

    Args:
        counts: points of each voxel with points, shape (k,).
        expected: points of a surface across each voxel, shape (k,); 0 gives the value 1.
    """
    return np.minimum(counts / np.maximum(expected, 1.0), 1.0).astype(np.float32)


@njit(cache=True)
def mark_touched_tiles(window: FrameWindow, cells: NDArray[np.int32], touched: NDArray[np.bool_]) -> None:
    """Mark the tiles of the window that contain cells.

    Args:
        window: box of voxels.
        cells: flat indices in the window, shape (k,).
        touched: output, shape (tiles, tiles) along x and y; set to True.
    """
    for cell in cells:
        column, row, _ = unravel_cell(cell, window.side, window.layers)
        touched[column // TILE_SIZE, row // TILE_SIZE] = True


@njit(cache=True)
def add_to_voxels(
    values: NDArray[np.float32],
    slots: NDArray[np.int64],
    window: FrameWindow,
    cells: NDArray[np.int32],
    amounts: NDArray[np.float32],
    limits: tuple[float, float],
) -> None:
    """Add amounts to voxel values and clamp them.

    Args:
        values: voxel values, shape (slots, TILE_SIZE, TILE_SIZE, layers).
        slots: slots of the window's tiles, shape (tiles, tiles); those of the cells exist.
        window: box of voxels.
        cells: flat indices in the window, shape (k,).
        amounts: amount for each cell, shape (k,), or (1,) for all.
        limits: lowest and highest value.
    """
    is_uniform = len(amounts) == 1
    for i, cell in enumerate(cells):
        column, row, layer = unravel_cell(cell, window.side, window.layers)
        slot = slots[column // TILE_SIZE, row // TILE_SIZE]
        value = values[slot, column % TILE_SIZE, row % TILE_SIZE, layer] + amounts[0 if is_uniform else i]
        values[slot, column % TILE_SIZE, row % TILE_SIZE, layer] = min(max(value, limits[0]), limits[1])
