import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from place_scenes import CAMERA, MOUNT
from stereo_calibrations import RealPairs, raw_calibrations, rectified_calibration
from taught_wall import HERE, RIG, seen

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from stereo_landmark.core.pair.camera_pair import CameraCalibration, Rectifier, stereo_rig
from stereo_landmark.core.pair.rectification_check import PairFault, check_pair
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

LEFT = rectified_calibration(CAMERA)
RAW_LEFT = PinholeCamera(752, 480, 690.0, 693.0, 370.0, 244.0, (-0.25, 0.06, 0.0005, -0.0008, 0.01))
RAW_RIGHT = PinholeCamera(752, 480, 704.0, 702.0, 380.5, 235.0, (-0.28, 0.07, -0.001, 0.0004, 0.0))
ROTATION, SHIFT = matrix_from_rpy((0.02, -0.03, 0.01)), np.array([-0.2, 0.004, -0.002])
"""X_right = ROTATION @ X_left + SHIFT [m]."""


def test_rectified_cameras_have_the_distance_of_the_real_ones():
    left, right = raw_calibrations(RAW_LEFT, RAW_RIGHT, ROTATION, SHIFT)
    rig = stereo_rig(left, right, MOUNT)
    assert rig.baseline == pytest.approx(np.linalg.norm(SHIFT), rel=1e-6)
    assert (rig.left, rig.right, rig.mount) == (left.rectified, right.rectified, MOUNT)


@pytest.mark.parametrize(
    ('rotation', 'projection', 'expected'),
    [
        ((1.0,) * 8, LEFT.projection, r'8 and projection_matrix .* 12'),
        ((0.0,) * 9, LEFT.projection, 'is not a rotation'),
        (LEFT.rotation, (0.0,) * 12, 'no focal length'),
        (LEFT.rotation, (*LEFT.projection[:3], math.nan, *LEFT.projection[4:]), 'not finite'),
        (LEFT.rotation, (*LEFT.projection[:7], -140.0, *LEFT.projection[8:]), 'baseline must be horizontal'),
    ],
)
def test_what_is_no_calibration_of_a_pair_is_refused(rotation, projection, expected):
    with pytest.raises(StereoLandmarkError, match=expected):
        CameraCalibration(CAMERA, rotation, projection)


SPOT = 3.0
"""Standard deviation of the drawn spots [px]."""


def spots(camera, points):
    """Return an image with a Gaussian spot at each projected point."""
    v, u = np.mgrid[: camera.height, : camera.width]
    image = np.zeros(u.shape)
    for place in camera.pixels_from_points(points):
        image += 200.0 * np.exp(-0.5 * ((u - place[0]) ** 2 + (v - place[1]) ** 2) / SPOT**2)
    return np.rint(image).astype(np.uint8)


def centre(image, near):
    """Return the centroid of the spot near a position."""
    u, v = np.rint(near).astype(int)
    window = image[v - 12 : v + 13, u - 12 : u + 13].astype(float)
    rows, columns = np.mgrid[v - 12 : v + 13, u - 12 : u + 13]
    return np.array([(window * columns).sum(), (window * rows).sum()]) / window.sum()


def test_rectified_images_show_points_where_the_rig_says():
    calibrations = raw_calibrations(RAW_LEFT, RAW_RIGHT, ROTATION, SHIFT)
    rig = stereo_rig(*calibrations, MOUNT)
    depths = np.random.default_rng(3).uniform(3.0, 4.0, (4, 3))
    rectified = np.dstack([*np.meshgrid((-0.9, -0.2, 0.5, 1.1), (-0.5, 0.1, 0.6), indexing='ij'), depths])
    rectified = rectified.reshape(-1, 3)
    # From the left rectified frame to the raw camera frames.
    left = rectified @ np.reshape(calibrations[0].rotation, (3, 3))
    seen = rig.project(rectified)
    for calibration, points, expected in (
        (calibrations[0], left, seen[:, :2]),
        (calibrations[1], left @ ROTATION.T + SHIFT, seen[:, 2:]),
    ):
        image = Rectifier(calibration).rectify(spots(calibration.raw, points))
        found = np.array([centre(image, place) for place in expected])
        assert np.abs(found - expected).max() < 0.06


def test_where_the_lens_shows_nothing_there_is_no_black_frame():
    lens = replace(CAMERA, distortion=(0.3, 0.0, 0.0, 0.0, 0.0))
    projection = np.column_stack([CAMERA.matrix * [[0.8], [0.8], [1.0]], np.zeros(3)])
    calibration = CameraCalibration(lens, tuple(np.eye(3).ravel()), tuple(projection.ravel().tolist()))
    assert (Rectifier(calibration).rectify(np.full((480, 752), 140, np.uint8)) == 140).all()


def test_an_image_of_another_size_is_refused():
    with pytest.raises(StereoLandmarkError, match='is 320 x 240 px, the calibration is for 752 x 480 px'):
        Rectifier(LEFT).rectify(np.zeros((240, 320), np.uint8))


def test_the_rows_of_real_pairs_agree_only_after_rectification():
    pairs = RealPairs()
    rig = stereo_rig(*pairs.calibrations, MOUNT)
    for role in ('teach', 'repeat'):
        raw = pairs.images(role)
        left, right = (Rectifier(each).rectify(image) for each, image in zip(pairs.calibrations, raw))
        assert check_pair(left, right, rig).fault is None
        assert check_pair(*raw, rig).fault is PairFault.NOT_RECTIFIED
        assert check_pair(right, left, rig).fault is PairFault.SWAPPED


BLANK = np.full((240, 376), 90, np.uint8)
NOISE = np.random.default_rng(1).integers(0, 256, (2, 240, 376), dtype=np.uint8)


@pytest.mark.parametrize(
    ('change', 'fault'),
    [
        (lambda left, right: (left, right), None),
        (lambda left, right: (left, np.roll(right, 3, axis=0)), PairFault.NOT_RECTIFIED),
        (lambda left, right: (left, np.roll(right, -4, axis=0)), PairFault.NOT_RECTIFIED),
        (lambda left, right: (right, left), PairFault.SWAPPED),
        (lambda left, right: (BLANK, BLANK), None),
        (lambda left, right: (BLANK, right), None),
        (lambda left, right: NOISE, None),
    ],
)
def test_rows_and_disparities_of_a_pair_are_checked_if_there_is_something_to_see(change, fault):
    assert check_pair(*change(*seen(HERE)), RIG).fault is fault


PATTERNS = {
    'chessboard': lambda x, y: (x // 30 + y // 30) % 2,
    'grille': lambda x, y: 0 * x + (y // 9) % 2,
    'mesh': lambda x, y: (x % 14 < 3) | (y % 14 < 3),
    'keypad': lambda x, y: (x % 40 > 8) & (y % 40 > 8) & (x // 40 < 16),
}


@pytest.mark.parametrize('name', PATTERNS)
def test_a_repeated_pattern_is_no_fault(name):
    y, x = np.mgrid[:480, :900]
    light = cv2.GaussianBlur(60.0 + 120.0 * PATTERNS[name](x, y), (0, 0), 1.0)
    noise = np.random.default_rng(1).normal(0.0, 2.0, (2, 480, 752))
    left, right = (np.uint8(light[:, u : u + 752] + each) for u, each in zip((100, 140), noise))
    assert check_pair(left, right, RIG).fault is None


@pytest.mark.parametrize('rows', [1, -1])
def test_one_row_is_seen_and_measured_in_a_real_pair(rows):
    pairs = RealPairs()
    left, right = (Rectifier(each).rectify(image) for each, image in zip(pairs.calibrations, pairs.images('teach')))
    checks = [
        check_pair(left, each, stereo_rig(*pairs.calibrations, MOUNT)) for each in (right, np.roll(right, rows, 0))
    ]
    assert [check.fault for check in checks] == [None, PairFault.NOT_RECTIFIED]
    assert checks[1].row_difference - checks[0].row_difference == pytest.approx(rows, abs=0.05)
    assert f'{checks[1].row_difference:.2f} px' in checks[1].summary
