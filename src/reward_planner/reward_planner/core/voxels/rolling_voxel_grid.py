"""Rolling voxel grid: tiles of voxels in bounded memory; the nearest ones are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.frame_window import TILE_SIZE, FrameWindow

_INITIAL_TILES = 64
NO_TILE = -1


class RollingVoxelGrid:
    """Voxel values of tiles in the slots of one growing array.

    Attributes:
        values: voxel values, shape (slots, TILE_SIZE, TILE_SIZE, layers), along x, y and z.
        frames: number of frames with points in the tile, shape (slots,).
        stamps: time of the last decay of the tile [s], shape (slots,).
        has_obstacle: columns with an uncleared obstacle of points, shape (slots, TILE_SIZE, TILE_SIZE).
    """

    def __init__(self, layers: int, tiles_max: int) -> None:
        """Start without tiles, for voxels in so many layers along z; a window has at most ``tiles_max`` tiles."""
        self._tiles_max = tiles_max
        self._slots: dict[tuple[int, int], int] = {}
        self.values = np.empty((0, TILE_SIZE, TILE_SIZE, layers), dtype=np.float32)
        self.frames = np.empty(0, dtype=np.float32)
        self.stamps = np.empty(0)
        self.has_obstacle = np.empty((0, TILE_SIZE, TILE_SIZE), dtype=np.bool_)
        self._grow(min(_INITIAL_TILES, tiles_max))

    def __len__(self) -> int:
        """Number of tiles."""
        return len(self._slots)

    @property
    def bytes(self) -> int:
        """Memory of all slots, used and free [bytes]."""
        return self.values.nbytes + self.frames.nbytes + self.stamps.nbytes + self.has_obstacle.nbytes

    def slots_of(self, window: FrameWindow) -> NDArray[np.int64]:
        """Return the slots of a window's tiles, shape (tiles, tiles) along x and y, NO_TILE for missing ones."""
        places = ((window.tile_x + i, window.tile_y + j) for i, j in np.ndindex(window.tiles, window.tiles))
        slots = [self._slots.get(place, NO_TILE) for place in places]
        return np.array(slots, dtype=np.int64).reshape(window.tiles, window.tiles)

    def allocate_missing(
        self, window: FrameWindow, slots: NDArray[np.int64], needed: NDArray[np.bool_], stamp: float
    ) -> None:
        """Allocate needed tiles of the window that are missing; the farthest tiles are evicted if there are too many.

        ``slots`` and ``needed`` have the shape (tiles, tiles); slots are updated in place.
        """
        missing = np.argwhere(needed & (slots == NO_TILE))
        if len(missing) == 0:
            return
        self._evict_farthest(window, len(missing))
        free = np.setdiff1d(np.arange(len(self.values)), np.fromiter(self._slots.values(), dtype=np.int64))
        for (i, j), slot in zip(missing.tolist(), free.tolist(), strict=False):
            place = (window.tile_x + i, window.tile_y + j)
            self._slots[place] = slots[i, j] = slot
            self.values[slot], self.frames[slot], self.has_obstacle[slot] = 0.0, 0.0, False
            self.stamps[slot] = stamp

    def clear(self) -> None:
        """Drop all tiles; the memory stays allocated."""
        self._slots.clear()

    def _evict_farthest(self, window: FrameWindow, count: int) -> None:
        """Provide ``count`` free slots: grow up to tiles_max, then evict the farthest tiles."""
        needed_slots = len(self._slots) + count
        if needed_slots > len(self.values):
            self._grow(min(max(needed_slots, 2 * len(self.values)), self._tiles_max))
        excess = needed_slots - len(self.values)
        if excess <= 0:
            return
        kept = np.array(list(self._slots))
        middle = np.array([window.tile_x, window.tile_y]) + 0.5 * (window.tiles - 1)
        farthest = np.argsort(np.abs(kept - middle).max(axis=1))[::-1][:excess]
        for place in kept[farthest].tolist():
            del self._slots[place[0], place[1]]

    def _grow(self, slots: int) -> None:
        extra = slots - len(self.values)
        self.values, self.frames, self.stamps, self.has_obstacle = (
            np.concatenate([array, np.zeros((extra, *array.shape[1:]), array.dtype)])
            for array in (self.values, self.frames, self.stamps, self.has_obstacle)
        )
