import re

import numpy as np
import pytest
from consistency import mahalanobis
from place_scenes import RIG, errors_of, panel, random_state, teach, view

from stereo_landmark.core.place.place_locator import NoPlaceFix, NoPlaceFixReason, PlaceFix, PlaceLocator
from stereo_landmark.core.settings import PlaceSettings
from stereo_landmark.core.stereo import StereoPoints

NOISE = 0.1


def pose_error(fix, state):
    return np.hypot(*errors_of(fix.T_place_base, fix.height, state)[:2])


@pytest.mark.parametrize('method', ['reprojection', 'closed_form'])
@pytest.mark.parametrize(('pixel', 'tilt', 'accuracy'), [(0.0, 0.0, 0.1), (0.3, 0.02, 0.2)])
@pytest.mark.newest_set_only
def test_errors_are_within_the_covariance_of_pixels_calibration_and_tilt(method, pixel, tilt, accuracy):
    """Pixels are off by the noise of the detection, or by a calibration error that it does not state."""
    rng = np.random.default_rng(1)
    settings = PlaceSettings(method=method, pixel_sigma=pixel, tilt_sigma=tilt, position_sigma_max=10.0)
    squares = []
    for _ in range(60):
        points, state = panel(seed=int(rng.integers(1000))), random_state(rng)
        seen = view(points, state, pixel or NOISE, rng)
        if pixel:
            seen = StereoPoints(seen.names, seen.pixels, 1e-6 * seen.covariances)
        taught = teach(points, 0.0 if pixel else NOISE, rng)
        fix = PlaceLocator(RIG, settings).locate(seen, taught, tuple(rng.normal(0.0, tilt, 2)))
        assert isinstance(fix, PlaceFix)
        squares.append(mahalanobis(errors_of(fix.T_place_base, fix.height, state), fix.covariance))
    assert np.sqrt(np.mean(squares)) == pytest.approx(1.0, abs=accuracy)


@pytest.mark.newest_set_only
def test_few_points_far_away_are_better_fitted_where_they_were_measured():
    """Four points within 110 px at 3.3 m: in 3D the depth noise dominates the pose, in pixels it does not."""
    rng = np.random.default_rng(2)
    errors = {'reprojection': [], 'closed_form': []}
    for _ in range(100):
        points, state = panel(3.3, 0.5, 4, seed=int(rng.integers(1000))), random_state(rng, 0.3, 0.1)
        seen, taught = view(points, state, 0.3, rng), teach(points, 0.3, rng)
        for method, found in errors.items():
            settings = PlaceSettings(method=method, position_sigma_max=10.0)
            fix = PlaceLocator(RIG, settings).locate(seen, taught)
            if isinstance(fix, PlaceFix):
                found.append(pose_error(fix, state))
    assert np.median(errors['closed_form']) > 1.5 * np.median(errors['reprojection'])


def test_a_known_lean_is_taken_out():
    rng = np.random.default_rng(3)
    points, state = panel(), random_state(rng)
    state[4:] = 0.02, -0.03
    seen, taught = view(points, state, NOISE, rng), teach(points, NOISE, rng)
    fix = PlaceLocator(RIG).locate(seen, taught, (0.02, -0.03))
    assert pose_error(fix, state) < 0.02
    free = PlaceLocator(RIG, PlaceSettings(tilt_sigma=0.5)).locate(seen, taught)
    assert free.tilt == pytest.approx((0.02, -0.03), abs=0.01)


@pytest.mark.parametrize(('rows', 'where'), [(0.8, 'lower'), (-0.8, 'higher')])
def test_a_row_mismatch_is_reported_with_its_remedy(rows, where):
    rng = np.random.default_rng(5)
    points, state = panel(), random_state(rng)
    seen = view(points, state, 0.02, rng)
    seen.pixels[:, 3] += rows
    answer = PlaceLocator(RIG).locate(seen, teach(points))
    assert isinstance(answer, NoPlaceFix)
    assert answer.reason is NoPlaceFixReason.ROW_MISMATCH
    assert re.search(rf'0\.(79|8|80|81) px {where}', answer.detail)


def test_unknown_points_do_not_count():
    points = panel()
    seen, taught = view(points, np.zeros(6)), teach(points)
    strange = StereoPoints(tuple(f'other {i}' for i in range(16)), seen.pixels, seen.covariances)
    answer = PlaceLocator(RIG).locate(strange, taught)
    assert answer == NoPlaceFix(
        NoPlaceFixReason.TOO_FEW_POINTS, '0 taught points are visible in both cameras, at least 2 are needed'
    )


@pytest.mark.parametrize('seed', range(5))
def test_points_that_do_not_fit_together_give_no_displacement(seed):
    rng = np.random.default_rng(seed)
    points = panel()
    seen, taught = view(points + rng.uniform(-0.4, 0.4, points.shape), np.zeros(6)), teach(points, NOISE, rng)
    answer = PlaceLocator(RIG).locate(seen, taught)
    assert isinstance(answer, NoPlaceFix)
    assert answer.reason is NoPlaceFixReason.INCONSISTENT


def test_what_is_too_uncertain_is_no_fix():
    rng = np.random.default_rng(6)
    points = panel(5.0, 0.2, 4, depth=0.0)
    settings = PlaceSettings(position_sigma_max=0.02)
    answer = PlaceLocator(RIG, settings).locate(view(points, np.zeros(6), 0.3, rng), teach(points, 0.3, rng))
    assert isinstance(answer, NoPlaceFix)
    assert answer.reason is NoPlaceFixReason.UNCERTAIN


@pytest.mark.parametrize('method', ['reprojection', 'closed_form'])
def test_two_points_have_an_honest_covariance(method):
    """Section 3.1: two points or more."""
    rng = np.random.default_rng(7)
    settings = PlaceSettings(method=method, pixel_sigma=0.0, tilt_sigma=0.0, position_sigma_max=10.0)
    squares = []
    for _ in range(100):
        left, right = rng.uniform(0.15, 0.8, 2)
        points = np.array([[3.0, left, 0.6], [3.0 + rng.uniform(-0.1, 0.1), -right, 0.6 + rng.uniform(-0.3, 0.3)]])
        state = random_state(rng)
        seen, taught = view(points, state, NOISE, rng), teach(points, NOISE, rng)
        fix = PlaceLocator(RIG, settings).locate(seen, taught)
        squares.append(mahalanobis(errors_of(fix.T_place_base, fix.height, state), fix.covariance))
    assert np.sqrt(np.mean(squares)) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize('method', ['reprojection', 'closed_form'])
def test_two_points_that_outliers_leave_are_not_enough(method):
    """Two of three points always fit together if their distance does: the third one must confirm them."""
    rng, points = np.random.default_rng(1), panel(count=3, depth=0.0)
    moved = points + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.2, 0.1]])
    locator = PlaceLocator(RIG, PlaceSettings(method=method))
    answer = locator.locate(view(moved, np.zeros(6), 0.05, rng), teach(points, 0.05, rng))
    assert isinstance(answer, NoPlaceFix)
    assert answer.reason is NoPlaceFixReason.INCONSISTENT
    two = view(points[:2], np.zeros(6), 0.05, rng)
    assert isinstance(locator.locate(two, teach(points, 0.05, rng)), PlaceFix)


@pytest.mark.parametrize('method', ['reprojection', 'closed_form'])
def test_two_points_above_each_other_do_not_determine_the_yaw(method):
    rng, points = np.random.default_rng(2), np.array([[3.0, 0.1, 0.5], [3.0, 0.1, 0.9]])
    locator = PlaceLocator(RIG, PlaceSettings(method=method))
    assert isinstance(locator.locate(view(points, np.zeros(6), 0.05, rng), teach(points, 0.05, rng)), NoPlaceFix)
