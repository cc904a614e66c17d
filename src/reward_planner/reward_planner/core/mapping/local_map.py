"""The map around the robot: voxels with a high value projected to the floor (2.2.3, step 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame
from reward_planner.core.voxels.frame_window import TILE
from reward_planner.core.voxels.sensor_view import SensorView
from reward_planner.core.voxels.tile_store import NO_TILE
from reward_planner.core.voxels.voxel_map import VoxelMap
from reward_planner.core.voxels.voxel_settings import FREE_SHARE

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
"""Values of cells, as in OccupancyGrid."""
_FREE_LAYERS = 0.5


@dataclass(frozen=True)
class LocalMap:
    """What the voxels around the robot say of the floor.

    Attributes:
        frame: where the cells are.
        occupancy: shape (rows, columns), OCCUPIED, FREE or UNKNOWN.
        observed: shape (rows, columns), where there is any evidence; cells with evidence may be UNKNOWN because it
            contradicts itself or has faded.
    """

    frame: GridFrame
    occupancy: NDArray[np.int8]
    observed: NDArray[np.bool_]


def project_around(voxels: VoxelMap, view: SensorView) -> LocalMap:
    """Project the voxels within reach of a view to the floor.

    A cell is occupied if any voxel over it has the value of an obstacle. It is free if none leans to occupied and rays
    passed the voxels from the lowest up without a gap, half of them at least: not where they only pass over a box, or
    under and over a shelf. The rules without rays find no cell free.
    """
    settings = voxels.settings
    window, slots = voxels.slots_around(view)
    is_mean = settings.rule != 'log_odds'
    least = settings.value_min if is_mean else settings.log_odds_occupied
    occupancy, observed = _project(
        voxels.tiles.values,
        voxels.tiles.frames if is_mean else np.ones(len(voxels.tiles.frames), dtype=np.float32),
        slots,
        (float(np.float32(least)), float(np.float32(-FREE_SHARE * settings.log_odds_pass))),  # as values are
    )
    x, y, _ = window.corner
    frame = GridFrame(float(x), float(y), window.resolution, window.side, window.side)
    return LocalMap(frame, occupancy, observed)


@njit(cache=True)
def _project(
    values: NDArray[np.float32],
    frames: NDArray[np.float32],
    slots: NDArray[np.int64],
    limits: tuple[float, float],
) -> tuple[NDArray[np.int8], NDArray[np.bool_]]:
    """Return occupancy and what was observed of the window's cells; rows along y.

    Args:
        values: shape (slots, TILE, TILE, layers).
        frames: shape (slots,), by which they are divided.
        slots: shape (tiles, tiles) along x and y.
        limits: lowest value of an obstacle, highest of free space.
    """
    side = TILE * len(slots)
    occupancy = np.full((side, side), UNKNOWN, dtype=np.int8)
    observed = np.zeros((side, side), dtype=np.bool_)
    for i, j in np.ndindex(slots.shape):
        slot = slots[i, j]
        if slot == NO_TILE:
            continue
        divisor = max(float(frames[slot]), 1.0)
        for column in range(TILE):
            for row in range(TILE):
                highest, passed, gapless, known = np.float32(0.0), 0, 0, 0
                for layer, value in enumerate(values[slot, column, row]):
                    highest = max(highest, value)
                    known += value != 0.0
                    passed += value <= limits[1]
                    gapless += passed == layer + 1
                cell = (j * TILE + row, i * TILE + column)
                observed[cell] = known > 0
                if highest >= limits[0] * divisor:
                    occupancy[cell] = OCCUPIED
                elif highest <= 0.0 and passed == gapless >= _FREE_LAYERS * values.shape[3]:
                    occupancy[cell] = FREE
    return occupancy, observed
