import math

import pytest
from geometry_msgs.msg import Quaternion
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Imu

from shirube_ros.errors import PoseError
from shirube_ros.pose_conversion import tilt_from_imu, tilt_from_quaternion


@pytest.mark.parametrize('rpy', [(0.0, 0.0, 0.0), (0.3, -0.2, 2.0), (-3.0, 1.5, -1.0), (0.0, 0.1, 3.1)])
def test_roll_and_pitch_are_those_of_the_rotation_whatever_the_yaw_and_the_length(rpy):
    x, y, z, w = (1.5 * Rotation.from_euler('xyz', rpy).as_quat()).tolist()
    assert tilt_from_imu(Imu(orientation=Quaternion(x=x, y=y, z=z, w=w)), 'imu') == pytest.approx(rpy[:2])


@pytest.mark.parametrize('wrong', [{'w': 0.0}, {'w': math.nan}])
def test_what_is_no_rotation_is_refused(wrong):
    with pytest.raises(PoseError, match='attitude holds'):
        tilt_from_quaternion(Quaternion(**wrong), 'attitude')


def test_an_imu_without_orientation_is_refused():
    with pytest.raises(PoseError, match='imu has no orientation'):
        tilt_from_imu(Imu(orientation_covariance=[-1.0, *[0.0] * 8]), 'imu')
