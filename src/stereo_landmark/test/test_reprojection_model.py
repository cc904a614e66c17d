import math

import numpy as np
import pytest
from place_scenes import RIG, panel

from stereo_landmark.core.place.reprojection import reproject

STATE = np.array([0.2, -0.1, 0.02, 0.3, 0.05, -0.08])


def test_derivatives_are_those_of_the_pixels():
    points = panel()
    seen = reproject(STATE, points, RIG)
    for i, step in enumerate(1e-6 * np.eye(6)):
        ahead, behind = (reproject(STATE + sign * step, points, RIG).pixels for sign in (1.0, -1.0))
        assert seen.state_jacobian[:, :, i] == pytest.approx((ahead - behind) / 2e-6, rel=1e-5, abs=1e-3)
    for i, step in enumerate(1e-6 * np.eye(3)):
        ahead, behind = (reproject(STATE, points + sign * step, RIG).pixels for sign in (1.0, -1.0))
        assert seen.point_jacobian[:, :, i] == pytest.approx((ahead - behind) / 2e-6, rel=1e-5, abs=1e-3)


def test_a_robot_at_the_taught_pose_sees_what_was_ahead_in_the_middle():
    ahead = np.array([[3.0, 0.1, 0.6]])
    (pixels,) = reproject(np.zeros(6), ahead, RIG).pixels
    assert pixels == pytest.approx([375.5, 239.5, 375.5 - 700.0 * 0.2 / 2.8, 239.5])


def test_with_the_nose_down_things_are_higher_in_the_image():
    (pixels,) = reproject(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1]), np.array([[3.0, 0.1, 0.6]]), RIG).pixels
    assert pixels[1] < 239.5 - 50.0


def test_points_behind_the_robot_are_marked():
    points = np.array([[3.0, 0.0, 0.6], [-3.0, 0.0, 0.6]])
    assert reproject(np.zeros(6), points, RIG).in_front.tolist() == [True, False]
    turned = reproject(np.array([0.0, 0.0, 0.0, math.pi, 0.0, 0.0]), points, RIG)
    assert turned.in_front.tolist() == [False, True]
