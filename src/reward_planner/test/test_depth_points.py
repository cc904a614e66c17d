"""Points of depth images: the pixels project back to themselves."""

import math

import numpy as np
import pytest
from l_rig import CAMERA, true_depth

from reward_planner.core.depth.trinocular_depth import points_from_depth_image
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import VoxelSettings
from shirube_core.geometry import PinholeCamera


def test_points_project_to_the_pixels_they_came_from():
    points = points_from_depth_image(true_depth(), CAMERA)
    pixels = CAMERA.pixels_from_points(points)
    v, u = np.mgrid[0.0 : CAMERA.height, 0.0 : CAMERA.width]
    assert np.allclose(pixels, np.column_stack([u.ravel(), v.ravel()]), atol=1e-3)
    assert (points[:, 2] == true_depth().ravel()).all()


@pytest.mark.parametrize('nearest', [0.0, 0.3])
def test_nothing_within_range_is_far_too_close_is_near_and_unknown_is_left_out(nearest):
    depth, known = true_depth().copy(), points_from_depth_image(true_depth(), CAMERA)
    depth[0, :5] = math.nan, 0.0, -1.0, math.inf, -math.inf
    points = points_from_depth_image(depth, CAMERA, nearest=nearest)
    assert len(points) == depth.size - (3 if nearest else 4)
    far = points[0].astype(np.float64)
    assert far[2] > 2.0 * VoxelSettings(range_max=50.0).range_max
    np.testing.assert_allclose(far / far[2], known[3] / known[3, 2], atol=1e-6)
    if nearest:
        assert np.linalg.norm(points[1]) == pytest.approx(nearest)
        np.testing.assert_allclose(points[1] / points[1, 2], known[4] / known[4, 2], atol=1e-6)


def test_an_image_that_does_not_fit_its_camera_is_refused():
    with pytest.raises(RewardPlannerError, match='320 x 240'):
        points_from_depth_image(np.ones((120, 160), dtype=np.float32), CAMERA)
    bent = PinholeCamera(320, 240, 262.5, 262.5, 159.5, 119.5, (0.1, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(RewardPlannerError, match='rectified'):
        points_from_depth_image(true_depth(), bent)
