"""Values over time: sums against a dictionary, clearing, decay, and jumps of the clock."""

from __future__ import annotations

import math

import numpy as np
import pytest
from slow_voxels import cells_as_voxels

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.voxels.frame_window import SensorView
from reward_planner.core.voxels.rolling_voxel_grid import NO_TILE
from reward_planner.core.voxels.voxel_map import VoxelMap
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.box_room import Box, BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(160, 120, 131.0, 131.0, 79.5, 59.5)
HALL: Box = (-4.0, -4.0, 0.0, 4.0, 4.0, 2.5)
BOX: Box = (1.5, -0.4, 0.0, 2.0, 0.4, 0.8)
SETTINGS = VoxelSettings(resolution=0.1, range_max=3.0)


def seen(boxes=(BOX,), x=0.0, y=0.0, yaw=0.0):
    T = forward_camera(x, y, 0.5, yaw)
    return points_from_depth(BoxRoom(HALL, tuple(boxes)).depth_image(CAMERA, T), CAMERA), SensorView(
        T, CAMERA.fx
    )


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
        assert (frames == k + 1).all()
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


def test_what_is_no_longer_seen_fades_also_after_time_jumped_back():
    voxels = VoxelMap(VoxelSettings(resolution=0.1, range_max=3.0, half_life=10.0))
    voxels.add(1e6, *seen())
    before = value_at(voxels, seen()[1], 1.55, 0.0, 0.5)
    voxels.add(0.0, *seen(yaw=math.pi))
    voxels.add(10.0, *seen(yaw=math.pi))
    assert value_at(voxels, seen()[1], 1.55, 0.0, 0.5) == pytest.approx(0.5 * before)


def test_a_frame_without_points_changes_nothing():
    voxels = VoxelMap(SETTINGS)
    points, view = seen()
    voxels.add(0.0, points, view)
    before = dense_values(voxels, view).copy()
    voxels.add(0.1, np.empty((0, 3)), view)
    voxels.add(0.2, np.full((50, 3), np.nan), view)
    assert (dense_values(voxels, view) == before).all()


def test_a_stamp_that_is_not_finite_is_refused():
    with pytest.raises(RewardPlannerError, match='stamp'):
        VoxelMap(SETTINGS).add(math.nan, *seen())


def test_a_cleared_map_is_empty():
    voxels = VoxelMap(SETTINGS)
    voxels.add(0.0, *seen())
    voxels.clear()
    assert len(voxels.tiles) == 0
    assert not dense_values(voxels, seen()[1]).any()
