import math
from dataclasses import replace

import numpy as np
import pytest
from consistency import whitened_rms
from place_scenes import RIG, panel, random_state, teach, view

from stereo_landmark.core.place.joint_fit import fit_reprojection, reproject
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import SpatialPoints

KNOWN_TILT = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.0)
FREE_TILT = PlaceSettings(pixel_sigma=0.0, tilt_sigma=0.5)
NOISE = 0.1


def joint_bound(points, state, free):
    """Return the Cramér-Rao bound of the state for a joint adjustment of taught and current images."""
    n = len(points)
    taught, now = reproject(np.zeros(6), points, RIG), reproject(state, points, RIG)
    rows = np.zeros((8 * n, free + 3 * n))
    for i in range(n):
        rows[4 * i : 4 * i + 4, free + 3 * i : free + 3 * i + 3] = taught.point_jacobian[i]
        rows[4 * (n + i) : 4 * (n + i) + 4, :free] = now.state_jacobian[i, :, :free]
        rows[4 * (n + i) : 4 * (n + i) + 4, free + 3 * i : free + 3 * i + 3] = now.point_jacobian[i]
    return np.linalg.inv(rows.T @ rows / NOISE**2)[:free, :free]


@pytest.mark.parametrize('count', [4, 16])
@pytest.mark.parametrize(('settings', 'free'), [(KNOWN_TILT, 4), (FREE_TILT, 6)])
@pytest.mark.newest_set_only
def test_errors_are_the_covariance_and_the_bound(count, settings, free):
    rng = np.random.default_rng(11)
    points, state = panel(count=count, depth=0.3), random_state(rng)
    fits = []
    for _ in range(200):
        seen, taught = view(points, state, NOISE, rng), teach(points, NOISE, rng)
        fits.append(fit_reprojection(seen, taught, RIG, np.zeros(6), settings))
    errors = np.array([fit.state - state for fit in fits])[:, :free]
    for covariance in (joint_bound(points, state, free), fits[0].covariance[:free, :free]):
        assert whitened_rms(errors, covariance) == pytest.approx(1.0, abs=0.13)


def test_without_noise_the_state_is_exact_from_far_away():
    rng = np.random.default_rng(2)
    for _ in range(20):
        points, state = panel(), random_state(rng, reach=0.5, turn=0.26)
        taught = SpatialPoints(view(points, state).names, points, np.zeros((16, 3, 3)))
        fit = fit_reprojection(view(points, state), taught, RIG, np.zeros(6), KNOWN_TILT)
        assert fit.state == pytest.approx(state, abs=1e-7)


def test_a_wrong_point_pulls_little():
    rng = np.random.default_rng(3)
    points, state = panel(), random_state(rng)
    seen, taught = view(points, state, NOISE, rng), teach(points, NOISE, rng)
    clean = fit_reprojection(seen, taught, RIG, np.zeros(6), KNOWN_TILT)
    seen.pixels[5] += [9.0, -6.0, 9.0, -6.0]
    pulled = fit_reprojection(seen, taught, RIG, np.zeros(6), KNOWN_TILT)
    assert np.abs(pulled.state - clean.state)[:2].max() < 0.01
    assert int(np.argmax(pulled.mahalanobis_distances)) == 5
    assert pulled.mahalanobis_distances[5] > 20.0


def test_one_point_determines_nothing():
    points = panel(count=1)
    assert fit_reprojection(view(points, np.zeros(6)), teach(points), RIG, np.zeros(6), KNOWN_TILT) is None


def test_calibration_errors_make_the_pose_less_certain():
    points, rng = panel(), np.random.default_rng(4)
    seen, taught = view(points, np.zeros(6), NOISE, rng), teach(points, NOISE, rng)
    exact, doubtful = (
        fit_reprojection(seen, taught, RIG, np.zeros(6), replace(KNOWN_TILT, pixel_sigma=sigma)).covariance
        for sigma in (0.0, 0.3)
    )
    assert (np.linalg.eigvalsh(doubtful - exact)[2:] > 0.0).all()


STATE = np.array([0.2, -0.1, 0.02, 0.3, 0.05, -0.08])


def test_derivatives_are_those_of_the_pixels():
    points = panel()
    seen = reproject(STATE, points, RIG)
    for i, step in enumerate(1e-6 * np.eye(9)):
        ahead, behind = (reproject(STATE + d[:6], points + d[6:], RIG).pixels for d in (step, -step))
        jacobian = np.dstack([seen.state_jacobian, seen.point_jacobian])[:, :, i]
        assert jacobian == pytest.approx((ahead - behind) / 2e-6, rel=1e-5, abs=1e-3)


def test_what_is_ahead_is_in_the_middle_and_higher_with_the_nose_down():
    ahead = np.array([[3.0, 0.1, 0.6]])
    (pixels,) = reproject(np.zeros(6), ahead, RIG).pixels
    assert pixels == pytest.approx([375.5, 239.5, 375.5 - 700.0 * 0.2 / 2.8, 239.5])
    (pixels,) = reproject(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1]), ahead, RIG).pixels
    assert pixels[1] < 239.5 - 50.0


def test_points_behind_the_robot_are_marked():
    points = np.array([[3.0, 0.0, 0.6], [-3.0, 0.0, 0.6]])
    assert reproject(np.zeros(6), points, RIG).in_front.tolist() == [True, False]
    turned = reproject(np.array([0.0, 0.0, 0.0, math.pi, 0.0, 0.0]), points, RIG)
    assert turned.in_front.tolist() == [False, True]
