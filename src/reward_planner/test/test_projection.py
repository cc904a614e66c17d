"""Projection of voxels: obstacles at the robot's heights, free cells along rays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import minimum_filter

from reward_planner.core.mapping.global_map import GlobalMap
from reward_planner.core.mapping.obstacle_mapper import project_voxels
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN
from reward_planner.core.voxels.frame_window import SensorView
from reward_planner.core.voxels.voxel_map import VoxelMap
from reward_planner.core.voxels.voxel_settings import VoxelSettings
from scene_simulator.box_room import BoxRoom, forward_camera, points_from_depth
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(320, 240, 262.0, 262.0, 159.5, 119.5)
HALL = (-3.0, -3.5, 0.0, 4.0, 3.5, 2.5)
BOX = (1.53, 0.23, 0.0, 2.02, 0.87, 0.6)
OVERHANG = (1.5, -0.8, 0.85, 2.2, -0.2, 1.0)
SETTINGS = VoxelSettings(resolution=0.1, range_max=3.0)


def project(boxes, settings=SETTINGS, yaw=0.0, frames=5):
    T = forward_camera(0.0, 0.0, 0.5, yaw)
    room, view = BoxRoom(HALL, boxes), SensorView(T, CAMERA.fx)
    points = points_from_depth(room.depth_image(CAMERA, T), CAMERA)
    voxels = VoxelMap(settings)
    for k in range(frames):
        voxels.add(0.1 * k, points, view)
    local = project_voxels(voxels, view, GlobalMap(settings.resolution, 1_000_000))
    frame = local.frame
    corner = (frame.origin_x, frame.origin_y)
    solid = room.solid_cells(
        corner, frame.resolution, frame.shape, (settings.height_min, settings.height_max)
    )
    return local, solid


def cell(local, x, y):
    row, column = local.frame.cell_of((x, y))
    return local.occupancy[row, column]


@pytest.mark.parametrize('rule', ['count', 'range_normalised', 'log_odds'])
def test_only_solid_cells_are_occupied(rule):
    settings = VoxelSettings(rule=rule, resolution=0.1, range_max=3.0)
    local, solid = project((BOX, OVERHANG), settings)
    assert solid[local.occupancy == OCCUPIED].all()
    assert (local.occupancy == OCCUPIED).sum() >= 5
    np.testing.assert_array_equal(local.observed, local.occupancy != UNKNOWN)


def test_the_face_of_a_box_is_occupied_and_the_floor_before_it_free():
    local, solid = project((BOX,))
    for y in (0.35, 0.45, 0.55, 0.65):
        assert cell(local, 1.55, y) == OCCUPIED
        assert cell(local, 1.25, y) == FREE
    # Rays go to the centres of voxels: they may cut the edge of a solid, never its inside.
    inside = minimum_filter(solid, 3)
    assert inside.sum() > 100
    assert not inside[local.occupancy == FREE].any()


def test_rows_go_along_y_and_columns_along_x():
    local, _ = project((BOX,))
    rows, columns = np.nonzero(local.occupancy == OCCUPIED)
    centres = local.frame.centre_of(np.column_stack([rows, columns]))
    assert centres[:, 0].min() == pytest.approx(1.55)
    assert (centres[:, 1] > 0.2).all()


def test_an_overhang_counts_only_if_the_robot_could_hit_it():
    tall, _ = project((OVERHANG,))
    low_robot = VoxelSettings(resolution=0.1, range_max=3.0, height_max=0.8)
    low, _ = project((OVERHANG,), low_robot)
    assert cell(tall, 1.55, -0.5) == OCCUPIED
    assert cell(low, 1.55, -0.5) == FREE


def test_cells_behind_a_high_box_stay_unknown():
    local, _ = project(((1.53, -0.5, 0.0, 1.9, 0.5, 1.3),))
    assert cell(local, 2.5, 0.0) == UNKNOWN
    assert not local.observed[tuple(local.frame.cell_of((2.5, 0.0)))]


def test_one_hit_is_no_obstacle_yet():
    local, _ = project((BOX,), frames=1)
    assert cell(local, 1.55, 0.5) == UNKNOWN
    assert not local.observed[tuple(local.frame.cell_of((1.55, 0.5)))]
    local, _ = project((BOX,), frames=2)
    assert cell(local, 1.55, 0.5) == OCCUPIED


def test_the_map_turns_with_the_view():
    ahead, _ = project((BOX,))
    aside, _ = project((BOX,), yaw=np.pi)
    assert cell(ahead, 1.55, 0.5) == OCCUPIED
    assert not aside.observed[tuple(aside.frame.cell_of((1.55, 0.5)))]
    assert cell(aside, -2.0, 0.0) == FREE


@pytest.mark.parametrize(
    'rule',
    [
        {'log_odds_occupied': 3.3, 'log_odds_max': 3.3},
        {'log_odds_pass': 1.4, 'log_odds_min': -0.7},
        {'log_odds_hit': 0.06, 'log_odds_pass': 5.0, 'log_odds_min': -2.5},
    ],
)
def test_at_the_limits_of_the_rule_there_are_still_obstacles_and_free_cells(rule):
    settings = VoxelSettings(resolution=0.1, range_max=3.0, **rule)
    local, _ = project((BOX,), settings, frames=20)
    assert cell(local, 1.55, 0.5) == OCCUPIED
    assert cell(local, 1.25, 0.5) == FREE
