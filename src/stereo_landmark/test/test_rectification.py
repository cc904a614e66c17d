from dataclasses import replace

import numpy as np
import pytest
from place_scenes import CAMERA, MOUNT
from stereo_calibrations import RealPairs, raw_calibrations

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, Rectifier, stereo_rig
from stereo_landmark.core.pair.epipolar_check import PairFault, pair_fault
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError

LEFT = PinholeCamera(752, 480, 690.0, 693.0, 370.0, 244.0, (-0.25, 0.06, 0.0005, -0.0008, 0.01))
RIGHT = PinholeCamera(752, 480, 704.0, 702.0, 380.5, 235.0, (-0.28, 0.07, -0.001, 0.0004, 0.0))
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
    calibrations = raw_calibrations(LEFT, RIGHT, ROTATION, SHIFT)
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
