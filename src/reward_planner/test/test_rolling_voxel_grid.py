"""Windows contain all points within range, invalid ones are rejected; tiles keep their values, the nearest are kept."""

import math

import numpy as np
import pytest

from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import VoxelSettings
from reward_planner.core.voxels.rolling_voxel_grid import (
    NO_TILE,
    TILE_SIZE,
    FrameWindow,
    RollingVoxelGrid,
    SensorView,
    check_voxel_settings,
    equivalent_focal_length,
    window_around,
    window_shape,
)
from scene_simulator.room.box_room import BoxRoom, forward_camera
from shirube_core.geometry import PinholeCamera


def view_at(x, y):
    T = np.eye(4)
    T[:2, 3] = x, y
    return SensorView(T, 500.0)


@pytest.mark.parametrize('resolution', [0.02, 0.05, 0.13])
def test_all_points_within_range_are_in_the_window(resolution):
    settings = VoxelSettings(resolution=resolution, tiles_max=100_000)
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(-1000.0, 1000.0, (200, 2)):
        window = window_around(view_at(x, y), settings)
        first = np.floor((np.array([x, y]) - settings.range_max - window.corner[:2]) / resolution)
        last = np.floor((np.array([x, y]) + settings.range_max - window.corner[:2]) / resolution)
        assert (first >= 0).all()
        assert (last < window.side).all()
        assert window.side % TILE_SIZE == 0


def test_layers_reach_from_the_lowest_to_the_highest_height():
    assert window_shape(VoxelSettings(height_min=0.1, height_max=1.2, resolution=0.05))[1] == 22
    assert window_shape(VoxelSettings(height_min=0.1, height_max=1.21, resolution=0.05))[1] == 23


@pytest.mark.parametrize(
    ('settings', 'words'),
    [
        (VoxelSettings(height_min=1.0, height_max=0.5), 'height_max is 0.5'),
        (VoxelSettings(height_min=0.5, height_max=0.5), 'height_min is 0.5'),
        (VoxelSettings(range_min=5.0, range_max=2.0), 'range_min is 5'),
        (VoxelSettings(range_min=2.0, range_max=2.0), 'range_max is 2'),
        (VoxelSettings(log_odds_occupied=4.0), 'is 4, it may not be more; log_odds_max is 3.5'),
        (VoxelSettings(log_odds_max=0.9), 'log_odds_max is 0.9'),
        (VoxelSettings(log_odds_pass=5.0, log_odds_min=-0.1), 'is -0.1, it must be -2.5 or less'),
        (VoxelSettings(resolution=0.01, tiles_max=100), 'tiles_max is 100'),
        (VoxelSettings(resolution=0.01, range_max=50.0, tiles_max=10**6), 'more than 2147483647; raise'),
    ],
)
def test_settings_that_contradict_each_other_are_refused(settings, words):
    with pytest.raises(RewardPlannerError, match=words) as refusal:
        check_voxel_settings(settings)
    assert '\n' not in str(refusal.value)


def test_a_sensor_beyond_all_maps_is_refused():
    with pytest.raises(RewardPlannerError, match='too far'):
        window_around(view_at(1e15, 0.0), VoxelSettings())


def changed(row, column, value):
    T = np.eye(4)
    T[row, column] = value
    return T


@pytest.mark.parametrize(
    ('T', 'words'),
    [
        (np.eye(3), 'not a rigid transform'),
        (changed(0, 3, math.nan), 'not a rigid transform'),
        (changed(1, 3, math.inf), 'not a rigid transform'),
        (changed(3, 0, 1.0), 'not a rigid transform'),
        (changed(0, 0, 1.1), 'orthonormal'),
        (changed(2, 2, -1.0), 'right-handed'),
    ],
)
def test_what_is_no_pose_is_refused(T, words):
    with pytest.raises(RewardPlannerError, match=words) as error:
        SensorView(T, 500.0)
    assert '\n' not in str(error.value)
    for focal_length in (-1.0, math.nan, math.inf):
        with pytest.raises(RewardPlannerError, match='focal_length'):
            SensorView(np.eye(4), focal_length)


ROOM = BoxRoom((-1.0, -2.0, 0.0, 4.0, 2.0, 2.4), ((1.5, -0.5, 0.0, 1.9, 0.1, 0.7),))


def cloud(focal_length, width=320, height=240):
    camera = PinholeCamera(width, height, focal_length, focal_length, 0.5 * width - 0.5, 0.5 * height - 0.5)
    depth = ROOM.depth_image(camera, forward_camera(0.0, 0.0, 0.5, 0.1)).astype(np.float32)
    return points_from_depth_image(depth, camera)


@pytest.mark.parametrize('focal_length', [150.0, 262.5, 400.0])
def test_it_is_the_focal_length_of_a_depth_image(focal_length):
    assert equivalent_focal_length(cloud(focal_length)) == pytest.approx(focal_length, rel=0.03)


def test_phantoms_and_gaps_hardly_change_it():
    points = cloud(262.5).copy()
    rng = np.random.default_rng(1)
    points[rng.choice(len(points), len(points) // 30, replace=False)] *= 0.3
    points[: len(points) // 4] = np.nan
    assert equivalent_focal_length(points) == pytest.approx(262.5, rel=0.05)


def test_each_point_of_a_sparse_cloud_counts():
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(-2.0, 2.0, (300, 2)), np.full(300, 2.0)]).astype(np.float32)
    assert equivalent_focal_length(points) < 60.0


def test_points_behind_the_camera_are_ignored():
    points = np.array([(0.1, 0.2, -1.0), (np.inf, 0.0, 1.0), (0.0, 0.0, 0.0)], dtype=np.float32)
    assert equivalent_focal_length(points) == 0.0
    assert equivalent_focal_length(np.empty((0, 3), dtype=np.float32)) == 0.0


def window(tile_x=0, tile_y=0, tiles=3):
    return FrameWindow(tile_x, tile_y, tiles * TILE_SIZE, 2, 0.05, 0.0)


def visit(store, at, stamp=0.0, needed=None):
    """Allocate all tiles of a window and return their slots."""
    slots = store.slots_of(at)
    store.allocate_missing(at, slots, np.full(slots.shape, True) if needed is None else needed, stamp)
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
    store.clear()
    assert len(store) == 0
    assert (store.slots_of(window(2994, 5)) == NO_TILE).all()


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
