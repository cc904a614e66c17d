"""Depth images and clearances in rooms against geometry worked out by hand."""

import math

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.room.box_room import (
    BoxRoom,
    add_disparity_noise,
    disc_clearance,
    forward_camera,
    points_from_depth,
)
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(64, 48, 50.0, 50.0, 31.5, 23.5)
ROOM = BoxRoom((-3.0, -2.0, 0.0, 4.0, 2.0, 2.5), ((1.0, -0.5, 0.0, 1.5, 0.5, 0.6), (2.0, 0.8, 0.7, 3.0, 1.6, 0.8)))


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


def test_a_box_without_volume_is_refused():
    with pytest.raises(SceneError, match='no volume'):
        BoxRoom((0.0, 0.0, 0.0, 1.0, 1.0, 0.0))


HALL = BoxRoom(
    (0.0, 0.0, 0.0, 4.0, 3.0, 2.5),
    ((1.0, 1.0, 0.0, 1.6, 1.4, 0.8), (2.5, 2.0, 0.7, 3.2, 2.6, 0.75), (2.0, 0.2, 1.5, 3.0, 1.0, 2.0)),
)
RADIUS, HEIGHT = 0.2, 1.3


def touches(x: float, y: float, radius: float) -> bool:
    """Look at many points of a disc."""
    angles = np.linspace(0.0, 2.0 * np.pi, 720)
    rim = radius * np.linspace(0.0, 1.0, 40)[:, None]
    px, py = x + rim * np.cos(angles), y + rim * np.sin(angles)
    solid = (px <= 0.0) | (px >= 4.0) | (py <= 0.0) | (py >= 3.0)
    for x0, y0, z0, x1, y1, _ in HALL.boxes:
        if z0 < HEIGHT:
            solid |= (px > x0) & (px < x1) & (py > y0) & (py < y1)
    return bool(solid.any())


@pytest.mark.parametrize('seed', range(60))
def test_a_disc_just_smaller_than_the_clearance_fits_and_one_just_larger_does_not(seed):
    x, y = np.random.default_rng(seed).uniform((0.05, 0.05), (3.95, 2.95)).tolist()
    free = disc_clearance(HALL, x, y, RADIUS, HEIGHT) + RADIUS
    if free > 0.02:
        assert not touches(x, y, free - 0.01)
    assert touches(x, y, free + 0.02)


def test_what_hangs_higher_does_not_count_for_a_low_robot():
    under = 2.5, 0.6
    assert disc_clearance(HALL, *under, RADIUS, 1.4) > 0.0
    assert disc_clearance(HALL, *under, RADIUS, 1.6) < 0.0
