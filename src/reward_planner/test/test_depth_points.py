"""Points of depth images: the pixels project back to themselves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from l_rig import CAMERA, true_depth

from reward_planner.core.depth.depth_points import points_from_depth_image
from reward_planner.core.reward_planner_error import RewardPlannerError
from shirube_core.geometry import PinholeCamera


def test_points_project_to_the_pixels_they_came_from():
    points = points_from_depth_image(true_depth(), CAMERA)
    pixels = CAMERA.pixels_from_points(points)
    v, u = np.mgrid[0.0 : CAMERA.height, 0.0 : CAMERA.width]
    assert np.allclose(pixels, np.column_stack([u.ravel(), v.ravel()]), atol=1e-3)
    assert (points[:, 2] == true_depth().ravel()).all()


def test_pixels_without_depth_are_left_out():
    depth = true_depth().copy()
    depth[0, :5] = math.nan, math.inf, -math.inf, 0.0, -1.0
    assert len(points_from_depth_image(depth, CAMERA)) == depth.size - 5


def test_an_image_that_does_not_fit_its_camera_is_refused():
    with pytest.raises(RewardPlannerError, match='320 x 240'):
        points_from_depth_image(np.ones((120, 160), dtype=np.float32), CAMERA)
    bent = PinholeCamera(320, 240, 262.5, 262.5, 159.5, 119.5, (0.1, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(RewardPlannerError, match='rectified'):
        points_from_depth_image(true_depth(), bent)
