"""Poses in the plane and in space, rotations and camera models, without ROS."""

from shirube_core.geometry.camera import CameraMount, PinholeCamera, TiltBuffer, gravity_aligned_camera
from shirube_core.geometry.lens import LensModel
from shirube_core.geometry.poses import (
    SE2,
    SE3,
    covariance_from_information,
    matrix_from_rpy,
    quaternion_from_yaw,
    rotation_matrix,
    wrap_angle,
    yaw_from_quaternion,
)

__all__ = [
    'SE2',
    'SE3',
    'CameraMount',
    'LensModel',
    'PinholeCamera',
    'TiltBuffer',
    'covariance_from_information',
    'gravity_aligned_camera',
    'matrix_from_rpy',
    'quaternion_from_yaw',
    'rotation_matrix',
    'wrap_angle',
    'yaw_from_quaternion',
]
