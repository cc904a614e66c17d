"""Voxel values over time, from points at known poses (2.2.2).

With ``count`` and ``range_normalised`` the value is the mean of the frames' values (step 3); a frame counts for a voxel
if it has points in it or rays through it. With ``log_odds`` a frame adds log-odds once to each hit voxel and subtracts
once from each traversed voxel, within limits, so that obstacles that disappear are cleared after a few frames.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import FREE_FRACTION, VoxelSettings
from reward_planner.core.voxels.frame_voxels import FrameVoxelizer, FrameVoxels, is_hit
from reward_planner.core.voxels.rolling_voxel_grid import (
    NO_TILE,
    TILE_SIZE,
    FrameWindow,
    RollingVoxelGrid,
    SensorView,
    check_voxel_settings,
    unravel_cell,
    window_around,
    window_shape,
)
from reward_planner.core.voxels.seen_again import forget_rest, look_again, note_changes

_MAXIMUM_QUANTILE = 0.99  # of the counts, M in eq. (3)
_DECAY_STEPS = 32  # decay updates per half-life
_RESIDUAL = np.float32(1e-6)  # positive values do not decay below this: only rays clear a hit voxel


class VoxelMap:
    """Voxels in the map frame.

    Attributes:
        settings: rule, sizes and limits.
        tiles: voxel values, to be read only.
    """

    def __init__(self, settings: VoxelSettings) -> None:
        """Start without voxels; errors are those of `check_voxel_settings`."""
        self.settings = settings
        self._voxelizer = FrameVoxelizer(settings)
        layers, is_mean = window_shape(settings)[1], settings.rule != 'log_odds'
        self.tiles = RollingVoxelGrid(layers, settings.tiles_max, counts_frames=is_mean)

    def apply_settings(self, settings: VoxelSettings) -> None:
        """Use other thresholds and log-odds, but the same sizes; errors are those of `check_voxel_settings`."""
        check_voxel_settings(settings)
        self.settings = self._voxelizer.settings = settings

    def add(self, stamp: float, points: ArrayLike, view: SensorView) -> FrameVoxels:
        """Add a frame and return its voxels; an occluded frame (`PointCounts.is_occluded`) adds nothing.

        Args:
            stamp: stamp of the frame [s]; values do not decay when the clock jumps back.
            points: points in the sensor frame [m], array-like, shape (n, 3); NaN and infinite ones are dropped.
            view: pose of the sensor at the stamp.

        Raises:
            RewardPlannerError: points of a wrong shape, or a stamp that is not finite.
        """
        if not math.isfinite(stamp):
            raise RewardPlannerError(f'the stamp is {stamp} s, it must be finite')
        # Step 1, fig. 2: count the points in the voxels around the sensor; their rays bound the detection range.
        frame = self._voxelizer.count_and_trace(points, view)
        if frame.point_counts.is_occluded:
            return frame
        # The tiles of the window: their values decay, and tiles that the frame touches are allocated.
        slots = self.tiles.slots_of(frame.window)
        frame, unseen = self._look_again(points, view, frame, slots)
        self._decay(slots[slots != NO_TILE], stamp)
        needed = touched_tiles(frame.window, frame.cells) | touched_tiles(frame.window, frame.traversed)
        self.tiles.allocate_missing(frame.window, slots, needed, stamp)
        # Steps 2 and 3: add the values of the frame, eq. (3); over the number of frames they are the mean over time.
        s = self.settings
        limits = (s.log_odds_min, s.log_odds_max) if s.rule == 'log_odds' else (0.0, math.inf)
        if s.rule != 'log_odds':
            once = np.ones(1, dtype=np.float32)
            for cells in (frame.cells, frame.traversed):
                add_to_voxels(self.tiles.frames, slots, frame.window, cells, once, limits)
        else:
            self._note_changes(frame, slots, unseen, stamp)
        for cells, amounts in self._values_of(frame):
            add_to_voxels(self.tiles.values, slots, frame.window, cells, amounts, limits)
        return frame

    def _look_again(
        self, points: ArrayLike, view: SensorView, frame: FrameVoxels, slots: NDArray[np.int64]
    ) -> tuple[FrameVoxels, NDArray[np.int8]]:
        """Return the frame with the voxels of obstacles that its rays passed, and columns out of view (log-odds)."""
        if self.settings.rule != 'log_odds' or view.focal_length == 0.0:
            return frame, np.zeros((0, 0), dtype=np.int8)
        cloud, occupied = np.ascontiguousarray(points, dtype=np.float32), self.settings.log_odds_occupied
        passed, unseen = look_again(self.tiles, slots, frame.window, cloud, view, occupied)
        return self._voxelizer.with_passed(frame, passed), unseen

    def _note_changes(
        self, frame: FrameVoxels, slots: NDArray[np.int64], unseen: NDArray[np.int8], stamp: float
    ) -> None:
        tiles, s = self.tiles, self.settings
        forget_rest(tiles, slots, frame.window, unseen, frame.traversed, stamp, s.obstacle_memory)
        arrays = tiles.values, tiles.was_free, tiles.cleared, tiles.changed
        free = -FREE_FRACTION * s.log_odds_pass
        change = stamp, s.log_odds_occupied, free, s.log_odds_pass, s.log_odds_hit
        hits = frame.cells[is_hit(frame, s.hit_fraction_min)]
        note_changes(arrays, slots, frame.window, hits, frame.traversed, change)

    def slots_around(self, view: SensorView) -> tuple[FrameWindow, NDArray[np.int64]]:
        """Return the window of a view and the slots of its tiles, shape (tiles, tiles) along x and y."""
        window = window_around(view, self.settings)
        return window, self.tiles.slots_of(window)

    def clear(self) -> None:
        """Drop all voxels."""
        self.tiles.clear()

    def _decay(self, slots: NDArray[np.int64], stamp: float) -> None:
        """Decay values by the time since the last decay of their tiles."""
        tiles, ages = self.tiles, stamp - self.tiles.stamps[slots]
        tiles.stamps[slots[ages < 0.0]] = stamp
        due = slots[ages * _DECAY_STEPS >= self.settings.half_life]
        if len(due) == 0:
            return
        decay = np.exp2((tiles.stamps[due] - stamp) / self.settings.half_life).astype(np.float32)
        values = tiles.values[due]
        tiles.values[due] = np.maximum(values * decay[:, None, None, None], np.minimum(values, _RESIDUAL))
        tiles.frames[due] *= decay[:, None, None, None]
        tiles.stamps[due] = stamp

    def _values_of(self, frame: FrameVoxels) -> list[tuple[NDArray[np.int32], NDArray[np.float32]]]:
        """Return cells and the amounts to add to them, shape (k,), or (1,) for all."""
        s = self.settings
        if s.rule == 'count':
            return [(frame.cells, counts_over_maximum(frame.counts))]
        if s.rule == 'range_normalised':
            return [(frame.cells, counts_over_expected(frame.counts, frame.expected))]
        hits = frame.cells[is_hit(frame, s.hit_fraction_min)]
        hit, traversed = (np.array([odds], dtype=np.float32) for odds in (s.log_odds_hit, -s.log_odds_pass))
        return [(hits, hit), (frame.traversed, traversed)]


def counts_over_maximum(counts: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return V = count / M, shape (k,), at most 1 (2.2.2, eq. 3).

    The paper defines M as "about the maximum of the counts of all voxels". Here it is the 99 % quantile of the frame's
    voxels with points, so that a single outlier does not scale all others.
    """
    if len(counts) == 0:
        return np.empty(0, dtype=np.float32)
    index = min(int(_MAXIMUM_QUANTILE * len(counts)), len(counts) - 1)
    M = np.partition(counts, index)[index]
    return np.minimum(counts / M, 1.0).astype(np.float32)


def counts_over_expected(counts: NDArray[np.int32], expected: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return count / (f s / Z)^2, shape (k,), at most 1: independent of the range; 1 where no point is expected."""
    return np.minimum(counts / np.maximum(expected, 1.0), 1.0).astype(np.float32)


@njit(cache=True)
def touched_tiles(window: FrameWindow, cells: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return which tiles of the window contain cells (flat indices, shape (k,)); shape (tiles, tiles)."""
    tiles = window.side // TILE_SIZE
    touched = np.zeros((tiles, tiles), dtype=np.bool_)
    for cell in cells:
        column, row, _ = unravel_cell(cell, window.side, window.layers)
        touched[column // TILE_SIZE, row // TILE_SIZE] = True
    return touched


@njit(cache=True)
def add_to_voxels(
    values: NDArray[np.float32],
    slots: NDArray[np.int64],
    window: FrameWindow,
    cells: NDArray[np.int32],
    amounts: NDArray[np.float32],
    limits: tuple[float, float],
) -> None:
    """Add amounts to voxel values, shape (slots, TILE_SIZE, TILE_SIZE, layers), and clamp them to limits.

    Cells are flat indices in the window, shape (k,), whose tiles have the slots, shape (tiles, tiles); there is an
    amount for each cell, shape (k,), or for all, shape (1,).
    """
    is_uniform = len(amounts) == 1
    for i, cell in enumerate(cells):
        column, row, layer = unravel_cell(cell, window.side, window.layers)
        slot = slots[column // TILE_SIZE, row // TILE_SIZE]
        value = values[slot, column % TILE_SIZE, row % TILE_SIZE, layer] + amounts[0 if is_uniform else i]
        values[slot, column % TILE_SIZE, row % TILE_SIZE, layer] = min(max(value, limits[0]), limits[1])
