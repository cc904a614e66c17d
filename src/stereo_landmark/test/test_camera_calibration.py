import math
from types import SimpleNamespace

import numpy as np
import pytest
from place_scenes import CAMERA, MOUNT
from stereo_calibrations import raw_calibrations, rectified_calibration, write_calibration

from shirube_core.geometry import PinholeCamera, matrix_from_rpy
from shirube_ros.file_errors import CalibrationError
from shirube_ros.message_error import CameraInfoError
from stereo_landmark.core.pair.camera_calibration import CameraCalibration, stereo_rig
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import load_camera_calibration
from stereo_landmark.files.recording import calibration_from_camera_info
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
