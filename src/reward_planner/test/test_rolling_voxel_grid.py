"""Tiles keep their values, and the nearest ones are kept within the budget."""

from __future__ import annotations

import numpy as np

from reward_planner.core.voxels.frame_window import TILE_SIZE, FrameWindow
from reward_planner.core.voxels.rolling_voxel_grid import NO_TILE, RollingVoxelGrid


def window(tile_x=0, tile_y=0, tiles=3):
    return FrameWindow(tile_x, tile_y, tiles * TILE_SIZE, 2, 0.05, 0.0)


def visit(store, at, stamp=0.0, needed=None):
    """Allocate all tiles of a window and return their slots."""
    slots = store.slots_of(at)
    store.allocate_missing(
        at, slots, np.ones(slots.shape, dtype=np.bool_) if needed is None else needed, stamp
    )
    return slots


def test_a_tile_keeps_its_values_when_the_window_moves():
    store = RollingVoxelGrid(2, 100)
    slots = visit(store, window())
    store.values[slots[2, 1]] = 7.0
    assert (store.values[visit(store, window(2, 0))[0, 1]] == 7.0).all()


def test_only_tiles_that_are_needed_are_made():
    store = RollingVoxelGrid(2, 100)
    needed = np.zeros((3, 3), dtype=np.bool_)
    needed[1, 2] = True
    slots = visit(store, window(), needed=needed)
    assert len(store) == 1
    assert ((slots != NO_TILE) == needed).all()


def test_memory_is_bounded_and_the_nearest_tiles_are_kept():
    store = RollingVoxelGrid(2, 20)
    for tile_x in range(0, 3000, 3):
        visit(store, window(tile_x, 5))
        assert len(store) <= 20
        assert (store.slots_of(window(tile_x, 5)) != NO_TILE).all()
    assert len(store.values) == 20
    assert (store.slots_of(window(2994, 5)) != NO_TILE).all()
    assert (store.slots_of(window(0, 5)) == NO_TILE).all()


def test_a_slot_that_is_used_again_begins_empty():
    store = RollingVoxelGrid(2, 9)
    store.values[visit(store, window())] = 3.0
    slots = visit(store, window(50, 50), stamp=4.0)
    assert (store.values[slots] == 0.0).all()
    assert (store.stamps[slots] == 4.0).all()


def test_no_two_tiles_share_a_slot():
    store = RollingVoxelGrid(2, 40)
    rng = np.random.default_rng(0)
    for _ in range(200):
        visit(store, window(*rng.integers(-9, 9, 2).tolist()), needed=rng.random((3, 3)) < 0.5)
        slots = store.slots_of(window(-12, -12, 24))
        used = slots[slots != NO_TILE]
        assert len(used) == len(set(used.tolist())) == len(store)


def test_a_cleared_store_has_no_tiles():
    store = RollingVoxelGrid(2, 20)
    visit(store, window())
    store.clear()
    assert len(store) == 0
    assert (store.slots_of(window()) == NO_TILE).all()
