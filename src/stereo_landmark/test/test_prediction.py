import math
import warnings

import numpy as np
import pytest
from place_scenes import RIG, panel

from stereo_landmark.core.place.reprojection import reproject
from stereo_landmark.core.procedure.prediction import image_distances, poses_from_match, predict_pixels
from stereo_landmark.core.procedure.stereo_view import StereoView

TILT = (0.04, -0.06)
VIEW = StereoView(None, None, RIG, TILT)


def test_points_are_expected_where_the_model_of_the_fit_projects_them():
    points, states = panel(), np.random.default_rng(1).uniform(-0.3, 0.3, (5, 4))
    for state, pixels in zip(states, predict_pixels(states, points, VIEW), strict=True):
        assert pixels == pytest.approx(reproject(np.array([*state, *TILT]), points, RIG).pixels, abs=1e-9)


def test_poses_through_a_point_see_it_where_it_was_found():
    found = np.array([[3.0, 0.2, 0.7], [2.5, -0.3, 0.9]])
    states = poses_from_match(np.array([3.1, 0.1, 0.75]), found, np.array([-0.2, 0.0, 0.3]))
    pixels = predict_pixels(states.reshape(-1, 4), np.array([[3.1, 0.1, 0.75]]), VIEW).reshape(2, 3, 4)
    there = predict_pixels(np.zeros((1, 4)), found, VIEW)[0]
    assert pixels == pytest.approx(np.repeat(there[:, None], 3, axis=1), abs=1e-6)


def test_poses_are_apart_by_what_they_have_before_them_in_common():
    states = np.array(
        [[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.01], [0.0, 0.0, 0.0, math.pi], [3.5, 0.0, 0.0, 0.0]]
    )
    points = np.vstack([panel(), [[6.0, 0.0, 0.6]]])
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        same, turned, away, beyond = image_distances(states, points, VIEW)
        behind = image_distances(states[[2, 0]], points, VIEW)
    assert same == 0.0
    assert turned == pytest.approx(0.01 * RIG.left.fx, rel=0.1)
    assert math.isinf(away)
    assert 0.0 < beyond < 60.0
    assert np.isinf(behind).all()
