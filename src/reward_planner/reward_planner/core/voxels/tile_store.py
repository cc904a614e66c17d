"""Tiles of voxels on an unbounded floor in bounded memory: the nearest ones are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.voxels.frame_window import TILE, FrameWindow

_FIRST_TILES = 64
NO_TILE = -1


class TileStore:
    """Voxel values of tiles in slots of one growing array.

    Attributes:
        values: shape (slots, TILE, TILE, layers), along x, y and z.
        frames: shape (slots,), frames with points in the tile.
        stamps: shape (slots,), when the tile was last brought up to date [s].
        held: shape (slots, TILE, TILE), columns with an obstacle that points showed and rays have not taken back.
    """

    def __init__(self, layers: int, tiles_max: int) -> None:
        """Begin without tiles.

        Args:
            layers: voxels along z.
            tiles_max: number of tiles that are kept, at least those of a window.
        """
        self._tiles_max = tiles_max
        self._slots: dict[tuple[int, int], int] = {}
        self.values = np.empty((0, TILE, TILE, layers), dtype=np.float32)
        self.frames = np.empty(0, dtype=np.float32)
        self.stamps = np.empty(0)
        self.held = np.empty((0, TILE, TILE), dtype=np.bool_)
        self._grow(min(_FIRST_TILES, tiles_max))

    def __len__(self) -> int:
        """Tiles that are kept."""
        return len(self._slots)

    @property
    def bytes(self) -> int:
        """Memory of the slots, used and free."""
        return self.values.nbytes + self.frames.nbytes + self.stamps.nbytes + self.held.nbytes

    def slots_of(self, window: FrameWindow) -> NDArray[np.int64]:
        """Return the slots of a window's tiles, shape (tiles, tiles) along x and y, NO_TILE where there is none."""
        across = range(window.tiles)
        rows = [
            [self._slots.get((window.tile_x + i, window.tile_y + j), NO_TILE) for j in across] for i in across
        ]
        return np.array(rows, dtype=np.int64)

    def add_missing(
        self, window: FrameWindow, slots: NDArray[np.int64], needed: NDArray[np.bool_], stamp: float
    ) -> None:
        """Make tiles where they are needed and missing; far ones give way once there are too many.

        Args:
            window: the tiles around the robot, which never give way.
            slots: shape (tiles, tiles), of the window; filled in.
            needed: shape (tiles, tiles).
            stamp: now [s].
        """
        missing = np.argwhere(needed & (slots == NO_TILE))
        if len(missing) == 0:
            return
        self._make_room(window, len(missing))
        free = np.setdiff1d(np.arange(len(self.values)), np.fromiter(self._slots.values(), dtype=np.int64))
        for (i, j), slot in zip(missing.tolist(), free.tolist(), strict=False):
            place = (window.tile_x + i, window.tile_y + j)
            self._slots[place] = slots[i, j] = slot
            self.values[slot], self.frames[slot], self.held[slot] = 0.0, 0.0, False
            self.stamps[slot] = stamp

    def clear(self) -> None:
        """Forget all tiles; the memory stays reserved."""
        self._slots.clear()

    def _make_room(self, window: FrameWindow, count: int) -> None:
        """Have as many free slots: grow while that is allowed, else drop the farthest tiles."""
        wanted = len(self._slots) + count
        if wanted > len(self.values):
            self._grow(min(max(wanted, 2 * len(self.values)), self._tiles_max))
        excess = wanted - len(self.values)
        if excess <= 0:
            return
        kept = np.array(list(self._slots))
        middle = np.array([window.tile_x, window.tile_y]) + 0.5 * (window.tiles - 1)
        farthest = np.argsort(np.abs(kept - middle).max(axis=1))[::-1][:excess]
        for place in kept[farthest].tolist():
            del self._slots[place[0], place[1]]

    def _grow(self, slots: int) -> None:
        extra = slots - len(self.values)
        self.values = np.concatenate([self.values, np.zeros((extra, *self.values.shape[1:]), np.float32)])
        self.frames = np.concatenate([self.frames, np.zeros(extra, np.float32)])
        self.stamps = np.concatenate([self.stamps, np.zeros(extra)])
        self.held = np.concatenate([self.held, np.zeros((extra, TILE, TILE), np.bool_)])
