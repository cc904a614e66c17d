"""Voxel values: of one frame, and over time."""

import math

import numpy as np
import pytest
from slow_voxels import cells_as_voxels

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.frame_voxels import FrameVoxelizer
from reward_planner.core.voxels.rolling_voxel_grid import NO_TILE, TILE_SIZE, FrameWindow, SensorView
from reward_planner.core.voxels.voxel_map import (
    VoxelMap,
    add_to_voxels,
    counts_over_expected,
    counts_over_maximum,
    touched_tiles,
)
from scene_simulator.room.box_room import Box, BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(160, 120, 131.0, 131.0, 79.5, 59.5)
HALL: Box = (-4.0, -4.0, 0.0, 4.0, 4.0, 2.5)
BOX: Box = (1.5, -0.4, 0.0, 2.0, 0.4, 0.8)
SETTINGS = VoxelSettings(resolution=0.1, range_max=3.0)


def seen(boxes=(BOX,), x=0.0, y=0.0, yaw=0.0):
    T = forward_camera(x, y, 0.5, yaw)
    return points_from_depth(BoxRoom(HALL, tuple(boxes)).depth_image(CAMERA, T), CAMERA), SensorView(T, CAMERA.fx)


def dense_values(voxels, view):
    """Values of a view's window, shape (side, side, layers)."""
    window, slots = voxels.slots_around(view)
    values = np.where((slots == NO_TILE)[..., None, None, None], 0.0, voxels.tiles.values[slots])
    return values.transpose(0, 2, 1, 3, 4).reshape(window.side, window.side, window.layers)


def value_at(voxels, view, x, y, z):
    """The value of the voxel at a point."""
    window, _ = voxels.slots_around(view)
    i, j, k = ((np.array([x, y, z]) - window.corner) / window.resolution).astype(int)
    return dense_values(voxels, view)[i, j, k]


def test_log_odds_are_the_sums_of_hits_and_passes_within_limits():
    voxels, book = VoxelMap(SETTINGS), {}
    for k in range(12):
        points, view = seen(() if k % 3 else (BOX,), x=0.05 * k, yaw=0.1 * k)
        frame = voxels.add(0.1 * k, points, view)
        firm = frame.counts >= np.maximum(SETTINGS.hit_fraction_min * frame.expected, 1.0)
        steps = dict.fromkeys(cells_as_voxels(frame.cells[firm], frame.window), SETTINGS.log_odds_hit)
        steps |= dict.fromkeys(cells_as_voxels(frame.traversed, frame.window), -SETTINGS.log_odds_pass)
        for voxel, step in steps.items():
            value = book.get(voxel, 0.0) + step
            book[voxel] = min(max(value, SETTINGS.log_odds_min), SETTINGS.log_odds_max)
    window, _ = voxels.slots_around(view)
    values = dense_values(voxels, view)
    cells = np.flatnonzero(values)
    inside = dict(zip(cells_as_voxels(cells, window), values.reshape(-1)[cells].tolist()))
    assert len(inside) > 2000
    for voxel, value in inside.items():
        assert value == pytest.approx(book[voxel], abs=1e-5)


def test_what_disappears_is_found_free():
    voxels = VoxelMap(SETTINGS)
    for k in range(40):
        voxels.add(0.1 * k, *seen())
    assert value_at(voxels, seen()[1], 1.55, 0.0, 0.5) == pytest.approx(SETTINGS.log_odds_max, abs=0.1)
    for k in range(40, 50):
        voxels.add(0.1 * k, *seen(()))
    assert value_at(voxels, seen()[1], 1.55, 0.0, 0.5) < 0.0


@pytest.mark.parametrize('rule', ['count', 'range_normalised'])
def test_the_mean_over_time_does_not_depend_on_the_number_of_frames(rule):
    voxels = VoxelMap(VoxelSettings(rule=rule, resolution=0.1, range_max=3.0))
    points, view = seen()
    means = []
    for k in range(5):
        voxels.add(0.1 * k, points, view)
        _, slots = voxels.slots_around(view)
        frames = voxels.tiles.frames[slots[slots != NO_TILE]]
        assert set(np.unique(frames).tolist()) == {0.0, k + 1.0}  # 0 where nothing was observed
        means.append(dense_values(voxels, view) / (k + 1))
    assert means[-1] == pytest.approx(means[0], abs=1e-6)
    assert 0.5 < means[0].max() <= 1.0


def test_what_is_no_longer_seen_fades_by_half_in_a_half_life():
    voxels = VoxelMap(VoxelSettings(resolution=0.1, range_max=3.0, half_life=10.0))
    _, view = seen()
    for k in range(10):
        voxels.add(0.1 * k, *seen())
    before = value_at(voxels, view, 1.55, 0.0, 0.5)
    voxels.add(0.9 + 10.0, *seen(yaw=math.pi))
    assert value_at(voxels, view, 1.55, 0.0, 0.5) == pytest.approx(0.5 * before, rel=0.1)


def test_fading_does_not_depend_on_how_often_frames_come():
    ends = []
    for frames in (1, 7, 300):
        voxels = VoxelMap(VoxelSettings(resolution=0.1, range_max=3.0, half_life=10.0))
        voxels.add(0.0, *seen())
        for stamp in np.linspace(0.0, 20.0, frames + 1)[1:]:
            voxels.add(stamp, *seen(yaw=math.pi))
        ends.append(value_at(voxels, seen()[1], 1.55, 0.0, 0.5))
    assert ends == pytest.approx([0.25 * SETTINGS.log_odds_hit] * 3, rel=0.05)


def test_nothing_is_lost_when_time_jumps_back():
    voxels = VoxelMap(SETTINGS)
    voxels.add(1e6, *seen())
    before = value_at(voxels, seen()[1], 1.55, 0.0, 0.5)
    voxels.add(0.0, *seen())
    assert value_at(voxels, seen()[1], 1.55, 0.0, 0.5) == pytest.approx(2.0 * before)
    voxels.add(1.0, *seen())
    assert value_at(voxels, seen()[1], 1.55, 0.0, 0.5) == pytest.approx(3.0 * before)
    voxels = VoxelMap(VoxelSettings(resolution=0.1, range_max=3.0, half_life=10.0))
    voxels.add(1e6, *seen())
    for stamp in (0.0, 10.0):  # what is no longer seen still fades
        voxels.add(stamp, *seen(yaw=math.pi))
    assert value_at(voxels, seen()[1], 1.55, 0.0, 0.5) == pytest.approx(0.5 * before)


def test_a_frame_without_points_or_a_finite_stamp_changes_nothing_and_a_cleared_map_is_empty():
    voxels = VoxelMap(SETTINGS)
    points, view = seen()
    voxels.add(0.0, points, view)
    before = dense_values(voxels, view).copy()
    voxels.add(0.1, np.empty((0, 3)), view)
    voxels.add(0.2, np.full((50, 3), np.nan), view)
    with pytest.raises(RewardPlannerError, match='stamp'):
        voxels.add(math.nan, points, view)
    assert (dense_values(voxels, view) == before).all()
    voxels.clear()
    assert len(voxels.tiles) == 0
    assert not dense_values(voxels, view).any()


WIDE_CAMERA = PinholeCamera(320, 240, 262.0, 262.0, 159.5, 119.5)
POLE_SETTINGS = VoxelSettings(resolution=0.1, height_min=0.1, height_max=1.2, value_min=0.2)
FACES = tuple((x, 0.2 * x - 0.24 * i) for i, x in enumerate((1.01, 1.91, 2.91, 3.91)))
POLES = BoxRoom((-1.0, -4.0, 0.0, 6.0, 4.0, 2.5), tuple((x, y, 0.0, x + 0.05, y + 0.21, 1.0) for x, y in FACES))


def voxels_of_poles():
    T = forward_camera(0.0, 0.0, 0.55, 0.0)
    points = points_from_depth(POLES.depth_image(WIDE_CAMERA, T), WIDE_CAMERA)
    frame = FrameVoxelizer(POLE_SETTINGS).count(points, SensorView(T, WIDE_CAMERA.fx))
    depth = 262.0 * 0.1 / np.sqrt(frame.expected)
    full = frame.counts > 0.5 * frame.expected
    return frame, depth, full


def test_the_printed_value_loses_far_voxels_and_the_normalised_value_keeps_them():
    frame, depth, full = voxels_of_poles()
    kept = counts_over_maximum(frame.counts) >= POLE_SETTINGS.value_min
    near, far = full & (depth < 1.5), full & (depth > 2.5) & (depth < 4.0)
    assert min(near.sum(), far.sum()) > 5
    assert kept[near].mean() > 0.9
    assert kept[far].mean() < 0.1
    kept = counts_over_expected(frame.counts, frame.expected) >= POLE_SETTINGS.value_min
    assert kept[full & ((depth < 1.5) | (depth > 2.5))].all()


def test_values_are_between_0_and_1_and_one_odd_voxel_does_not_rule_over_the_others():
    counts = np.array([1, 5, 80, 1000], dtype=np.int32)
    expected = np.array([0.0, 10.0, 80.0, 9.0])
    for values in (counts_over_maximum(counts), counts_over_expected(counts, expected)):
        assert (values > 0.0).all()
        assert (values <= 1.0).all()
    assert counts_over_maximum(counts) == pytest.approx(counts / 1000.0)
    assert len(counts_over_maximum(np.empty(0, dtype=np.int32))) == 0
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
    touched = touched_tiles(window, cells[:3])
    x, y, _ = np.unravel_index(cells[:3], dense.shape)
    assert {(i, j) for i, j in np.argwhere(touched).tolist()} == set(
        zip((x // TILE_SIZE).tolist(), (y // TILE_SIZE).tolist())
    )
