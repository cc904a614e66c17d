"""The camera after rectification is that of P."""

import pytest
from sensor_msgs.msg import CameraInfo

from shirube_core.geometry import PinholeCamera
from shirube_ros.camera.info import projection_from_camera_info, rectified_camera
from shirube_ros.errors import CameraInfoError

K = [90.0, 0.0, 60.0, 0.0, 91.0, 40.0, 0.0, 0.0, 1.0]
P = [100.0, 0.0, 64.0, -12.0, 0.0, 101.0, 48.0, 3.0, 0.0, 0.0, 1.0, 0.0]


def test_p_counts_and_not_k() -> None:
    info = CameraInfo(width=128, height=96, k=K, p=P, d=[0.1, 0.0, 0.0, 0.0, 0.0])
    assert rectified_camera(info, 'info') == PinholeCamera(128, 96, 100.0, 101.0, 64.0, 48.0)
    assert projection_from_camera_info(info, 'info')[:2, 3].tolist() == [-12.0, 3.0]


def test_without_p_k_counts_unless_there_is_distortion() -> None:
    info = CameraInfo(width=128, height=96, k=K)
    assert rectified_camera(info, 'info') == PinholeCamera(128, 96, 90.0, 91.0, 60.0, 40.0)
    info.d = [0.1, 0.0, 0.0, 0.0, 0.0]
    with pytest.raises(CameraInfoError, match='distortion and no P'):
        rectified_camera(info, 'info')
    with pytest.raises(CameraInfoError, match='P is zero'):
        projection_from_camera_info(info, 'info')


def test_an_impossible_p_is_refused() -> None:
    with pytest.raises(CameraInfoError, match='focal length'):
        rectified_camera(CameraInfo(width=128, height=96, k=K, p=[-1.0, *P[1:]]), 'info')
