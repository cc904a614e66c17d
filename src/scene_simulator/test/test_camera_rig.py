"""The cameras of the rig see the same point with the disparities of their baselines."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.camera_rig import CameraRig
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
