"""Pictures of a room: the same surface looks the same from elsewhere."""

from __future__ import annotations

import numpy as np

from scene_simulator.box_room import BoxRoom, forward_camera
from scene_simulator.box_room_rendering import render_picture
from shirube_core.geometry import PinholeCamera

CAMERA = PinholeCamera(160, 120, 131.0, 131.0, 79.5, 59.5)
WALL = BoxRoom((-1.0, -5.0, -3.0, 2.62, 5.0, 4.0))


def taken(y=0.0, z=0.6, noise=0.0, seed=0):
    return render_picture(WALL, CAMERA, forward_camera(0.0, y, z, 0.0), noise, np.random.default_rng(seed))


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
