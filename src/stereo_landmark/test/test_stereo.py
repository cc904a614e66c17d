import numpy as np
import pytest
from consistency import whitened_rms
from place_scenes import CAMERA, MOUNT, RIG, panel, view

from shirube_core.geometry import PinholeCamera
from stereo_landmark.core.stereo import StereoRig, is_measurable, triangulate
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


def in_left_camera(points):
    return (points - np.array(RIG.mount.xyz)) @ RIG.mount.rotation


def test_points_are_found_where_they_are():
    points = panel()
    found = triangulate(view(points, np.zeros(6)), RIG)
    assert found.positions == pytest.approx(in_left_camera(points), abs=1e-9)


def test_the_covariance_is_that_of_the_errors():
    rng = np.random.default_rng(3)
    points = panel(distance=4.0, count=8)
    errors = []
    for _ in range(400):
        found = triangulate(view(points, np.zeros(6), 0.2, rng), RIG)
        errors.append(found.positions - in_left_camera(points))
    assert whitened_rms(errors, found.covariances) == pytest.approx(1.0, abs=0.03)
    assert whitened_rms(errors, found.covariances, axis=0) == pytest.approx(np.ones((8, 3, 1)), abs=0.15)


def test_points_without_disparity_are_not_measurable():
    seen = view(panel(count=4), np.zeros(6))
    seen.pixels[1, 2] = seen.pixels[1, 0]
    seen.pixels[2, 2] = seen.pixels[2, 0] + 3.0
    assert is_measurable(seen, RIG).tolist() == [True, False, False, True]


def test_another_frame_turns_the_covariance_too():
    found = triangulate(view(panel(count=3), np.zeros(6), 0.2, np.random.default_rng(1)), RIG)
    moved = found.transform(RIG.mount.rotation, np.array(RIG.mount.xyz))
    assert np.linalg.eigvalsh(moved.covariances) == pytest.approx(np.linalg.eigvalsh(found.covariances))
    # In the base frame depth is along x, the least certain direction of a stereo pair.
    assert (moved.covariances[:, 0, 0] > 10.0 * moved.covariances[:, 2, 2]).all()
