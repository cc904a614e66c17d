import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from place_scenes import CAMERA, MOUNT
from stereo_calibrations import RealPairs, raw_calibrations, rectified_calibration, write_calibration
from taught_wall import HERE, RIG, seen

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from shirube_ros.errors import CalibrationError, CameraInfoError
from stereo_landmark.core.pair.camera_pair import (
    CameraCalibration,
    PairFault,
    Rectifier,
    pair_fault,
    stereo_rig,
)
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import calibration_from_camera_info, load_camera_calibration
from stereo_landmark.files.yaml_file import LandmarkFileError

LEFT, RIGHT = rectified_calibration(CAMERA), rectified_calibration(CAMERA, 0.2)
OTHER = PinholeCamera(752, 480, 700.0, 702.0, 380.5, 235.0, (-0.2, 0.05, 0.001, -0.001, 0.0))


def message(calibration, **changes):
    """Return a CameraInfo."""
    raw = calibration.raw
    fields = {
        'width': raw.width,
        'height': raw.height,
        'distortion_model': 'plumb_bob',
        'k': raw.matrix.ravel(),
        'd': raw.distortion,
        'r': calibration.rotation,
        'p': calibration.projection,
    }
    return SimpleNamespace(**(fields | changes))


def test_the_rig_has_the_baseline_of_the_projection_matrix():
    rig = stereo_rig(LEFT, RIGHT, MOUNT)
    assert rig.baseline == pytest.approx(0.2)
    assert (rig.left, rig.right, rig.mount) == (CAMERA, CAMERA, MOUNT)


def test_rectified_cameras_have_the_distance_of_the_real_ones():
    rotation, shift = matrix_from_rpy((0.02, -0.03, 0.01)), np.array([-0.15, 0.004, -0.002])
    left, right = raw_calibrations(CAMERA, OTHER, rotation, shift)
    assert stereo_rig(left, right, MOUNT).baseline == pytest.approx(np.linalg.norm(shift), rel=1e-6)


@pytest.mark.parametrize('pair', [(LEFT, LEFT), (RIGHT, LEFT)])
def test_no_baseline_or_one_of_the_wrong_sign_is_refused(pair):
    with pytest.raises(StereoLandmarkError, match=r'baseline is -?0(\.2)? m, it must be positive.*swapped\?'):
        stereo_rig(*pair, MOUNT)


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


def test_files_and_messages_give_the_same_calibration(tmp_path):
    calibration = raw_calibrations(CAMERA, OTHER, np.eye(3), [-0.2, 0.0, 0.0])[1]
    assert load_camera_calibration(write_calibration(tmp_path / 'right.yaml', calibration)) == calibration
    assert calibration_from_camera_info(message(calibration), 'right/camera_info') == calibration


def test_messages_of_cameras_that_are_not_calibrated_as_a_pair_are_refused():
    with pytest.raises(CameraInfoError, match=r'right/camera_info: .*focal length'):
        calibration_from_camera_info(message(RIGHT, p=np.zeros(12)), 'right/camera_info')
    with pytest.raises(CameraInfoError, match='right/camera_info is not calibrated'):
        calibration_from_camera_info(message(RIGHT, k=np.zeros(9)), 'right/camera_info')


def test_files_without_rectification_are_refused(tmp_path):
    path = write_calibration(tmp_path / 'left.yaml', LEFT)
    text = path.read_text()
    path.write_text(text.replace('projection_matrix', 'projection'))
    with pytest.raises(LandmarkFileError, match=r'left\.yaml: projection_matrix with its data is missing'):
        load_camera_calibration(path)
    path.write_text(text.replace('camera_matrix', 'camera'))
    with pytest.raises(CalibrationError, match=r'left\.yaml: camera_matrix'):
        load_camera_calibration(path)


RAW_LEFT = PinholeCamera(752, 480, 690.0, 693.0, 370.0, 244.0, (-0.25, 0.06, 0.0005, -0.0008, 0.01))
RAW_RIGHT = PinholeCamera(752, 480, 704.0, 702.0, 380.5, 235.0, (-0.28, 0.07, -0.001, 0.0004, 0.0))
ROTATION, SHIFT = matrix_from_rpy((0.02, -0.03, 0.01)), np.array([-0.2, 0.004, -0.002])
"""X_right = ROTATION @ X_left + SHIFT [m]."""
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
    rng = np.random.default_rng(3)
    rectified = np.array(
        [[x, y, 3.0 + rng.uniform()] for x in (-0.9, -0.2, 0.5, 1.1) for y in (-0.5, 0.1, 0.6)]
    )
    # From the left rectified frame to each raw camera frame.
    R_left, R_right = (np.array(each.rotation).reshape(3, 3) for each in calibrations)
    left = rectified @ R_left
    seen = rig.project(rectified)
    for calibration, points, expected in (
        (calibrations[0], left, seen[:, :2]),
        (calibrations[1], left @ ROTATION.T + SHIFT, seen[:, 2:]),
    ):
        image = Rectifier(calibration).rectify(spots(calibration.raw, points))
        found = np.array([centre(image, place) for place in expected])
        assert np.abs(found - expected).max() < 0.06
    assert np.allclose(R_right @ (ROTATION @ left[0] + SHIFT), rectified[0] - [rig.baseline, 0.0, 0.0])


def test_where_the_lens_shows_nothing_there_is_no_black_frame():
    lens = replace(CAMERA, distortion=(0.3, 0.0, 0.0, 0.0, 0.0))
    projection = np.column_stack([CAMERA.matrix * [[0.8], [0.8], [1.0]], np.zeros(3)])
    calibration = CameraCalibration(lens, tuple(np.eye(3).ravel()), tuple(projection.ravel().tolist()))
    assert (Rectifier(calibration).rectify(np.full((480, 752), 140, np.uint8)) == 140).all()


def test_an_image_of_another_size_is_refused():
    calibration = raw_calibrations(CAMERA, CAMERA, np.eye(3), [-0.2, 0.0, 0.0])[0]
    with pytest.raises(StereoLandmarkError, match='is 320 x 240 px, the calibration is for 752 x 480 px'):
        Rectifier(calibration).rectify(np.zeros((240, 320), np.uint8))


def test_the_rows_of_real_pairs_agree_only_after_rectification():
    pairs = RealPairs()
    rig = stereo_rig(*pairs.calibrations, MOUNT)
    for role in ('teach', 'repeat'):
        raw = pairs.images(role)
        left, right = (Rectifier(each).rectify(image) for each, image in zip(pairs.calibrations, raw))
        assert pair_fault(left, right, rig) is None
        assert pair_fault(*raw, rig) is PairFault.NOT_RECTIFIED
        assert pair_fault(right, left, rig) is PairFault.SWAPPED


def test_a_good_pair_has_no_fault():
    assert pair_fault(*seen(HERE), RIG) is None


def test_row_differences_of_some_pixels_are_detected():
    left, right = seen(HERE)
    assert pair_fault(left, np.roll(right, 3, axis=0), RIG) is PairFault.NOT_RECTIFIED
    assert pair_fault(left, np.roll(right, -4, axis=0), RIG) is PairFault.NOT_RECTIFIED


def test_swapped_images_are_detected():
    assert pair_fault(*seen(HERE)[::-1], RIG) is PairFault.SWAPPED


def test_where_there_is_nothing_to_see_nothing_is_said():
    blank = np.full((240, 376), 90, np.uint8)
    assert pair_fault(blank, blank, RIG) is None
    assert pair_fault(blank, seen(HERE)[1], RIG) is None
    noise = np.random.default_rng(1).integers(0, 256, (2, 240, 376), dtype=np.uint8)
    assert pair_fault(*noise, RIG) is None
