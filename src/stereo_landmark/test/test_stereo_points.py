import numpy as np
import pytest
from place_scenes import RIG, panel, view

from stereo_landmark.core.stereo import is_measurable, triangulate


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
    whitened = np.linalg.inv(np.linalg.cholesky(found.covariances)) @ np.array(errors)[..., None]
    assert np.sqrt(np.mean(whitened**2)) == pytest.approx(1.0, abs=0.03)
    assert np.sqrt(np.mean(whitened**2, axis=0)) == pytest.approx(np.ones((8, 3, 1)), abs=0.15)


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
