"""Voxel values of a frame: the paper's rule loses far voxels, the normalised one does not."""

from __future__ import annotations

import numpy as np
import pytest

from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.frame_window import TILE_SIZE, FrameWindow, SensorView
from reward_planner.core.voxels.voxel_map import (
    add_to_voxels,
    counts_over_expected,
    counts_over_maximum,
    touched_tiles,
)
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.box_room import BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(320, 240, 262.0, 262.0, 159.5, 119.5)
SETTINGS = VoxelSettings(resolution=0.1, height_min=0.1, height_max=1.2)
FACES = tuple((x, 0.2 * x - 0.24 * i) for i, x in enumerate((1.01, 1.91, 2.91, 3.91)))
POLES = BoxRoom(
    (-1.0, -4.0, 0.0, 6.0, 4.0, 2.5), tuple((x, y, 0.0, x + 0.05, y + 0.21, 1.0) for x, y in FACES)
)


def voxels_of_poles():
    T = forward_camera(0.0, 0.0, 0.55, 0.0)
    points = points_from_depth(POLES.depth_image(CAMERA, T), CAMERA)
    frame = FrameVoxelizer(SETTINGS).count(points, SensorView(T, CAMERA.fx))
    depth = 262.0 * 0.1 / np.sqrt(frame.expected)
    full = frame.counts > 0.5 * frame.expected
    return frame, depth, full


def test_the_printed_value_loses_far_voxels_that_are_as_full_as_near_ones():
    frame, depth, full = voxels_of_poles()
    kept = counts_over_maximum(frame.counts) >= SETTINGS.value_min
    near, far = full & (depth < 1.5), full & (depth > 2.5) & (depth < 4.0)
    assert near.sum() > 5
    assert far.sum() > 5
    assert kept[near].mean() > 0.9
    assert kept[far].mean() < 0.1


def test_the_normalised_value_keeps_near_and_far_voxels():
    frame, depth, full = voxels_of_poles()
    kept = counts_over_expected(frame.counts, frame.expected) >= SETTINGS.value_min
    assert kept[full & (depth < 1.5)].all()
    assert kept[full & (depth > 2.5)].all()


def test_values_are_between_0_and_1():
    counts = np.array([1, 5, 80, 1000], dtype=np.int32)
    for values in (
        counts_over_maximum(counts),
        counts_over_expected(counts, np.array([0.0, 10.0, 80.0, 9.0])),
    ):
        assert (values > 0.0).all()
        assert (values <= 1.0).all()
    assert len(counts_over_maximum(np.empty(0, dtype=np.int32))) == 0


def test_one_odd_voxel_does_not_rule_over_the_others():
    counts = np.full(1000, 50, dtype=np.int32)
    counts[3] = 100_000
    assert counts_over_maximum(counts).min() == 1.0


def test_amounts_reach_the_voxels_they_are_meant_for():
    window = FrameWindow(0, 0, 3 * TILE_SIZE, 5, 0.05, 0.0)
    rng = np.random.default_rng(0)
    cells = rng.permutation(window.side**2 * window.layers)[:500].astype(np.int32)
    amounts = rng.normal(size=500).astype(np.float32)
    slots = rng.permutation(9).reshape(3, 3)
    values = np.zeros((9, TILE_SIZE, TILE_SIZE, 5), dtype=np.float32)
    add_to_voxels(values, slots, window, cells, amounts, (-1.0, 1.5))
    dense = np.zeros((window.side, window.side, 5), dtype=np.float32)
    dense.reshape(-1)[cells] = np.clip(amounts, -1.0, 1.5)
    tiles = values[slots].transpose(0, 2, 1, 3, 4).reshape(dense.shape)
    assert tiles == pytest.approx(dense)
    touched = np.zeros((3, 3), dtype=np.bool_)
    touched_tiles(window, cells[:3], touched)
    x, y, _ = np.unravel_index(cells[:3], dense.shape)
    assert {(i, j) for i, j in np.argwhere(touched).tolist()} == set(
        zip((x // TILE_SIZE).tolist(), (y // TILE_SIZE).tolist())
    )
