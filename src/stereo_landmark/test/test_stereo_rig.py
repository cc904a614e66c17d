import numpy as np
import pytest
from place_scenes import CAMERA, MOUNT, RIG

from shirube_core.geometry import PinholeCamera
from stereo_landmark.core.stereo import StereoRig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError


def test_both_cameras_are_pinholes_one_baseline_apart():
    points = np.random.default_rng(1).uniform([-1.0, -1.0, 1.0], [1.0, 1.0, 5.0], (50, 3))
    pixels = RIG.project(points)
    assert pixels[:, :2] == pytest.approx(CAMERA.pixels_from_points(points))
    assert pixels[:, 2:] == pytest.approx(CAMERA.pixels_from_points(points - [0.2, 0.0, 0.0]))


def test_derivatives_are_those_of_the_projections():
    points = np.random.default_rng(2).uniform([-1.0, -1.0, 1.0], [1.0, 1.0, 5.0], (20, 3))
    jacobians = RIG.jacobians(points)
    for axis, step in enumerate(1e-6 * np.eye(3)):
        change = (RIG.project(points + step) - RIG.project(points - step)) / 2e-6
        assert jacobians[:, :, axis] == pytest.approx(change, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize('baseline', [0.0, -0.2, float('nan')])
def test_a_baseline_that_is_not_positive_is_refused(baseline):
    with pytest.raises(StereoLandmarkError, match='swapped'):
        StereoRig(CAMERA, CAMERA, baseline, MOUNT)


def test_cameras_that_are_no_pair_are_refused():
    other = PinholeCamera(752, 480, 710.0, 700.0, 375.5, 239.5)
    with pytest.raises(StereoLandmarkError, match='fx is 700 in the left and 710'):
        StereoRig(CAMERA, other, 0.2, MOUNT)
