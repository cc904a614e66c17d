"""Depth images of rooms against geometry worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.box_room import (
    BoxRoom,
    add_disparity_noise,
    add_spurious_depths,
    forward_camera,
    points_from_depth,
)
from scene_simulator.errors import SceneError
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(64, 48, 50.0, 50.0, 31.5, 23.5)
ROOM = BoxRoom(
    (-3.0, -2.0, 0.0, 4.0, 2.0, 2.5), ((1.0, -0.5, 0.0, 1.5, 0.5, 0.6), (2.0, 0.8, 0.7, 3.0, 1.6, 0.8))
)


def test_points_are_on_the_surfaces_of_the_room():
    T = forward_camera(-1.0, 0.3, 0.9, 0.4)
    points = points_from_depth(ROOM.depth_image(CAMERA, T), CAMERA) @ T[:3, :3].T + T[:3, 3]
    solids = np.array(ROOM.boxes)
    on_room = np.minimum(np.abs(points - ROOM.size[:3]), np.abs(points - ROOM.size[3:])).min(axis=1)
    outside = np.maximum(solids[:, None, :3] - points, points - solids[:, None, 3:]).max(axis=2)
    assert np.minimum(on_room, np.abs(outside).min(axis=0)).max() < 1e-5
    assert outside.min() > -1e-5


def test_the_nearest_surface_is_seen():
    depth = ROOM.depth_image(CAMERA, forward_camera(0.0, 0.0, 0.3, 0.0))
    assert depth[24, 32] == pytest.approx(1.0)
    over_the_box = ROOM.depth_image(CAMERA, forward_camera(0.0, 0.0, 1.0, 0.0))
    assert over_the_box[24, 32] == pytest.approx(4.0)


def test_the_camera_turns_with_the_yaw():
    to_the_left = ROOM.depth_image(CAMERA, forward_camera(0.0, 0.0, 1.0, math.pi / 2.0))
    assert to_the_left[24, 32] == pytest.approx(2.0)


def test_solid_cells_are_those_of_boxes_and_walls_at_the_heights():
    solid = ROOM.solid_cells((-3.23, -2.23), 0.1, (46, 76), (0.1, 0.65))
    box = np.zeros_like(solid)
    box[17:28, 42:48] = True
    inner = np.zeros_like(solid)
    inner[3:42, 3:72] = True
    assert (solid[inner] == box[inner]).all()
    assert solid[:3].all()
    assert solid[:, 72:].all()
    with_table = ROOM.solid_cells((-3.23, -2.23), 0.1, (46, 76), (0.1, 1.0))
    assert with_table[32, 55]
    assert not solid[32, 55]


def test_noise_of_the_depth_grows_with_its_square():
    rng = np.random.default_rng(1)
    near = add_disparity_noise(np.full((200, 200), 1.0, np.float32), 50.0, 0.1, rng)
    far = add_disparity_noise(np.full((200, 200), 3.0, np.float32), 50.0, 0.1, rng)
    assert far.std() / near.std() == pytest.approx(9.0, rel=0.05)


def test_phantoms_are_as_many_as_asked_for():
    depth = np.full((480, 640), 9.0, dtype=np.float32)
    for patch in (1, 8):
        image = add_spurious_depths(depth, 0.03, patch, (0.5, 5.0), np.random.default_rng(2))
        assert (image != depth).mean() == pytest.approx(0.03, rel=0.05)


def test_a_box_without_volume_is_refused():
    with pytest.raises(SceneError, match='no volume'):
        BoxRoom((0.0, 0.0, 0.0, 1.0, 1.0, 0.0))
