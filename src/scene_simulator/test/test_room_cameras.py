"""Disparities are those of the baselines, surfaces look the same from everywhere; a drive is clear of furniture."""

import math

import numpy as np
import pytest

from scene_simulator.room.box_room import BoxRoom, forward_camera
from scene_simulator.room.room_drive import CameraRig, RoomDrive, render_picture
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(320, 240, 260.0, 250.0, 159.5, 119.5)
RIG = CameraRig(CAMERA, CameraMount((0.1, 0.0, 0.4), (-math.pi / 2.0, 0.0, -math.pi / 2.0)), 0.12)


def test_disparities_are_f_b_over_z():
    point = np.array([4.3, 1.0, 0.9, 1.0])
    pixels = {}
    for name, T in RIG.views(SE2(1.0, 0.5, 0.2)).items():
        x, y, z, _ = np.linalg.solve(T, point)
        pixels[name] = np.array([CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy])
    assert z > 2.0
    assert pixels['left'] - pixels['right'] == pytest.approx((CAMERA.fx * 0.12 / z, 0.0))
    assert pixels['left'] - pixels['top'] == pytest.approx((0.0, -CAMERA.fy * 0.12 / z))


def test_the_top_camera_is_above_and_the_right_one_to_the_right():
    views = RIG.views(SE2(0.0, 0.0, 0.0))
    np.testing.assert_allclose(views['left'][:3, 3], (0.1, 0.0, 0.4), atol=1e-12)
    np.testing.assert_allclose(views['right'][:3, 3], (0.1, -0.12, 0.4), atol=1e-12)
    np.testing.assert_allclose(views['top'][:3, 3], (0.1, 0.0, 0.52), atol=1e-12)


SMALL_CAMERA = PinholeCamera(160, 120, 131.0, 131.0, 79.5, 59.5)
WALL = BoxRoom((-1.0, -5.0, -3.0, 2.62, 5.0, 4.0))


def taken(y=0.0, z=0.6, noise=0.0, seed=0):
    camera = forward_camera(0.0, y, z, 0.0)
    return render_picture(WALL, SMALL_CAMERA, camera, noise, np.random.default_rng(seed))


def test_a_wall_moves_by_the_disparity_when_the_camera_moves():
    left = taken()
    # 131 px x 0.1 m / 2.62 m is 5 px, sideways and upwards.
    assert (left[:, 5:] == taken(y=-0.1)[:, :-5]).mean() > 0.98
    assert (left[:-5] == taken(z=0.7)[5:]).mean() > 0.98


def test_the_pattern_has_contrast_and_does_not_repeat():
    picture = taken().astype(float)
    assert picture.std() > 15.0
    shifted = [np.corrcoef(picture[:, k:].ravel(), picture[:, :-k].ravel())[0, 1] for k in (20, 40, 60)]
    assert max(shifted) < 0.3


def test_noise_is_as_strong_as_asked_for():
    difference = taken(noise=2.0, seed=1).astype(float) - taken(noise=2.0, seed=2)
    assert 2.6 < difference.std() < 3.1


@pytest.mark.parametrize('seed', [1, 2, 3])
def test_the_drive_hits_nothing(seed):
    scene = RoomDrive(seed)
    poses = [scene.drive.pose_at(t) for t in np.arange(0.0, scene.drive.duration, 0.05)]
    way = np.array([(pose.x, pose.y) for pose in poses])
    assert min(piece.distances_to(way).min() for piece in scene.room.furniture) > 0.45
    low, high = np.array(scene.size[:2]), np.array(scene.size[3:5])
    assert np.minimum(way - low, high - way).min() > 0.45


def test_pictures_of_a_place_differ_by_their_noise():
    one, other = (RoomDrive(1).pictures(index, 2.0) for index in (4, 5))
    for name in ('left', 'right', 'top'):
        assert 0.5 < np.abs(one[name].astype(float) - other[name]).mean() < 5.0


def test_the_localizer_is_a_little_off():
    scene = RoomDrive(1)
    errors = [scene.localizer_pose(k, 0.1 * k).distance_to(scene.drive.pose_at(0.1 * k)) for k in range(200)]
    assert np.sqrt(np.mean(np.square(errors)) / 2.0) == pytest.approx(scene.pose_noise[0], rel=0.15)
