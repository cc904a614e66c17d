"""Poses and tilts to messages and back."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

from shirube_core.geometry import SE2
from shirube_ros.errors import PoseError
from shirube_ros.message_conversion import (
    base_odometry,
    odometry_message,
    planar_pose,
    planar_pose_with_covariance,
    pose_message,
    pose_stamped,
    pose_with_covariance_message,
    pose_with_covariance_stamped,
    tilt_from_imu,
    tilt_from_quaternion,
)

RNG = np.random.default_rng(9)
POSES = [SE2(*RNG.uniform(-3.0, 3.0, 3)) for _ in range(10)]
COVARIANCE = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])


@pytest.mark.parametrize('pose', POSES)
def test_poses_come_back_from_every_message(pose: SE2) -> None:
    header = Header(frame_id='map')
    odometry = odometry_message(pose, COVARIANCE, header, 'base_link')
    assert (odometry.header.frame_id, odometry.child_frame_id) == ('map', 'base_link')
    stamped = pose_stamped(pose, header)
    with_covariance = pose_with_covariance_stamped(pose, COVARIANCE, header)
    assert stamped.header.frame_id == with_covariance.header.frame_id == 'map'
    for message in (pose_message(pose), odometry.pose.pose, stamped.pose, with_covariance.pose.pose):
        back = planar_pose(message, 'pose')
        assert pose.distance_to(back) < 1e-12
        assert pose.yaw_to(back) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('child', ['', 'base_link'])
def test_odometry_is_that_of_the_base(child: str) -> None:
    message = odometry_message(POSES[0], COVARIANCE, Header(frame_id='odom'), child)
    assert base_odometry(message, 'odom', 'base_link').distance_to(POSES[0]) < 1e-12
    message.child_frame_id = 'wheel'
    with pytest.raises(PoseError, match="odom has child_frame_id 'wheel', base_frame is 'base_link'"):
        base_odometry(message, 'odom', 'base_link')


def test_the_covariance_has_the_layout_of_ros() -> None:
    message = pose_with_covariance_message(SE2(0.0, 0.0, 0.0), COVARIANCE)
    full = np.array(message.covariance).reshape(6, 6)
    assert (full[0, 0], full[1, 1], full[5, 5]) == (4.0, 3.0, 2.0)
    assert (full[0, 1], full[5, 0], full[1, 5]) == (1.0, 0.5, 0.2)
    assert not full[2:5].any()
    np.testing.assert_array_equal(planar_pose_with_covariance(message, 'pose')[1], COVARIANCE)


@pytest.mark.parametrize('length', [0.5, 2.0])
def test_heading_is_the_fixed_axis_yaw_of_any_quaternion(length: float) -> None:
    x, y, z, w = Rotation.from_euler('xyz', [0.1, -0.2, 2.0]).as_quat() * length
    message = Pose(position=Point(z=9.0), orientation=Quaternion(x=x, y=y, z=z, w=w))
    assert planar_pose(message, 't').yaw == pytest.approx(2.0)


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (Pose(position=Point(x=math.nan)), r'odom holds a pose that is not finite'),
        (Pose(position=Point(y=math.inf)), r'not finite'),
        (Pose(orientation=Quaternion(z=math.nan)), r'not finite'),
        (Pose(orientation=Quaternion(w=0.0)), r'odom holds a quaternion of zeros; .* set w to 1'),
    ],
)
def test_broken_poses_are_refused(message: Pose, words: str) -> None:
    with pytest.raises(PoseError, match=words):
        planar_pose(message, 'odom')


@pytest.mark.parametrize(
    ('covariance', 'words'),
    [
        (np.zeros((3, 3)), r'not positive definite for x, y and yaw'),
        (np.diag([1.0, 1.0, -1.0]), r'not positive'),
        (np.diag([1.0, math.nan, 1.0]), r'finite'),
        (np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), r'symmetric'),
    ],
)
def test_broken_covariances_are_refused(covariance: np.ndarray, words: str) -> None:
    message = pose_with_covariance_message(POSES[0], covariance)
    with pytest.raises(PoseError, match=words):
        planar_pose_with_covariance(message, 'initialpose')


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
