"""CameraInfo messages to cameras, raw and rectified."""

import math
from typing import Any

import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, RegionOfInterest

from shirube_core.geometry import LensModel, PinholeCamera
from shirube_ros.camera.info import (
    camera_from_camera_info,
    check_image_size,
    projection_from_camera_info,
    rectified_camera,
)
from shirube_ros.errors import CameraInfoError

K = [340.0, 0.0, 116.0, 0.0, 338.0, 118.0, 0.0, 0.0, 1.0]
D = [-0.3, 0.1, 0.001, -0.002, 0.01]


def info(**changes: Any) -> CameraInfo:
    good = {'width': 235, 'height': 230, 'distortion_model': 'plumb_bob', 'k': K, 'd': D}
    return CameraInfo(**(good | changes))


def test_every_number_lands_in_its_place() -> None:
    expected = PinholeCamera(235, 230, 340.0, 338.0, 116.0, 118.0, (-0.3, 0.1, 0.001, -0.002, 0.01))
    assert camera_from_camera_info(info(), 'camera_info') == expected


@pytest.mark.parametrize('model', ['', 'plumb_bob'])
def test_missing_coefficients_are_zero(model: str) -> None:
    assert camera_from_camera_info(info(distortion_model=model, d=[]), 't').distortion == (0.0,) * 5
    assert camera_from_camera_info(info(distortion_model=model, d=D[:4]), 't').distortion == (*D[:4], 0.0)


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'k': [0.0] * 9}, r'camera_info is not calibrated, K is zero; calibrate the camera'),
        ({'k': [0.0, *K[1:]]}, r'focal length'),
        ({'k': [math.nan, *K[1:]]}, r'not finite'),
        ({'width': 0}, r'image size is 0 x 230'),
        ({'d': [math.inf, *D[1:]]}, r'not finite'),
        ({'distortion_model': 'division'}, r"'division'; calibrate with one of plumb_bob, rational_.*, equidis"),
        ({'distortion_model': 'equidistant'}, r"'equidistant' with 5 numbers instead of 4; calibrate"),
        ({'distortion_model': 'rational_polynomial'}, r'with 5 numbers instead of 8 or 12 or 14'),
        ({'d': D[:3]}, r"'plumb_bob' with 3 numbers instead of 0 or 4 or 5"),
        ({'roi': RegionOfInterest(x_offset=200, width=100, height=9)}, r'100 x 9 px at \(200, 0\) in an image'),
    ],
)
def test_bad_calibrations_are_refused_with_the_remedy(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(CameraInfoError, match=words) as refusal:
        camera_from_camera_info(info(**changes), 'camera_info')
    assert str(refusal.value).startswith('camera_info')


@pytest.mark.parametrize(
    ('model', 'count'),
    [('rational_polynomial', 8), ('rational_polynomial', 12), ('rational_polynomial', 14), ('equidistant', 4)],
)
def test_other_models_keep_their_coefficients(model: str, count: int) -> None:
    d = [0.01 * (i + 1) for i in range(count)]
    camera = camera_from_camera_info(info(distortion_model=model, d=d), 't')
    assert (camera.model, camera.distortion) == (LensModel(model), tuple(d))
    if count in (4, 14):  # the most that the model has: zeros beyond it are dropped
        assert camera_from_camera_info(info(distortion_model=model, d=[*d, 0.0]), 't') == camera


def test_region_and_binning_move_the_pixels_of_a_point() -> None:
    whole, P = (
        camera_from_camera_info(info(), 't'),
        [100.0, 0.0, 64.0, -12.0, 0.0, 101.0, 48.0, 3.0, 0.0, 0.0, 1.0, 0.0],
    )
    roi = RegionOfInterest(x_offset=20, y_offset=31, width=101, height=60, do_rectify=True)
    message = info(roi=roi, binning_x=3, binning_y=2, p=P)
    part = camera_from_camera_info(message, 't')
    assert (part.width, part.height) == (33, 30)
    # The middle of a block of 3 x 2 pixels is the middle of the pixel that they become.
    u, v = whole.pixels_from_points([[0.1, -0.05, 1.0]])[0]
    expected = [((u - 20.0) - 1.0) / 3.0, ((v - 31.0) - 0.5) / 2.0]
    np.testing.assert_allclose(part.pixels_from_points([[0.1, -0.05, 1.0]]), [expected], atol=1e-9)
    rectified = rectified_camera(message, 't')
    u, v = rectified_camera(info(p=P), 't').pixels_from_points([[0.1, -0.05, 1.0]])[0]
    expected = [((u - 20.0) - 1.0) / 3.0, ((v - 31.0) - 0.5) / 2.0]
    np.testing.assert_allclose(rectified.pixels_from_points([[0.1, -0.05, 1.0]]), [expected], atol=1e-9)
    np.testing.assert_allclose(projection_from_camera_info(message, 't')[:, 3], [-4.0, 1.5, 0.0])


def test_the_image_must_have_the_size_of_its_calibration() -> None:
    camera = camera_from_camera_info(info(), 't')
    check_image_size(camera, (230, 235), 'image_raw', 'camera_info')
    check_image_size(camera, (230, 235, 3), 'image_raw', 'camera_info')
    with pytest.raises(CameraInfoError, match='image_raw is 230 x 235 px but camera_info is for 235 x 230'):
        check_image_size(camera, (235, 230), 'image_raw', 'camera_info')


RECTIFIED_K = [90.0, 0.0, 60.0, 0.0, 91.0, 40.0, 0.0, 0.0, 1.0]
P = [100.0, 0.0, 64.0, -12.0, 0.0, 101.0, 48.0, 3.0, 0.0, 0.0, 1.0, 0.0]


def test_p_counts_and_not_k() -> None:
    info = CameraInfo(width=128, height=96, k=RECTIFIED_K, p=P, d=[0.1, 0.0, 0.0, 0.0, 0.0])
    assert rectified_camera(info, 'info') == PinholeCamera(128, 96, 100.0, 101.0, 64.0, 48.0)
    assert projection_from_camera_info(info, 'info')[:2, 3].tolist() == [-12.0, 3.0]


def test_without_p_k_counts_unless_there_is_distortion() -> None:
    info = CameraInfo(width=128, height=96, k=RECTIFIED_K)
    assert rectified_camera(info, 'info') == PinholeCamera(128, 96, 90.0, 91.0, 60.0, 40.0)
    info.d = [0.1, 0.0, 0.0, 0.0, 0.0]
    with pytest.raises(CameraInfoError, match='distortion and no P'):
        rectified_camera(info, 'info')
    with pytest.raises(CameraInfoError, match='P is zero'):
        projection_from_camera_info(info, 'info')
    info.p = [-1.0, *P[1:]]
    with pytest.raises(CameraInfoError, match='focal length'):
        rectified_camera(info, 'info')
