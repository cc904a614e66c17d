"""The density of a cloud is that of its depth camera."""

import numpy as np
import pytest

from reward_planner.core.depth.depth_points import points_from_depth_image
from reward_planner.core.voxels.frame_window import equivalent_focal_length
from scene_simulator.box_room import BoxRoom, forward_camera
from shirube_core.geometry import PinholeCamera

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
