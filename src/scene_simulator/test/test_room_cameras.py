"""The cameras see the same point with the disparities of their baselines, and the same surface looks the same."""

import math

import numpy as np
import pytest

from scene_simulator.room.box_room import BoxRoom, forward_camera
from scene_simulator.room.cameras import CameraRig, render_picture
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
