"""Poses in the plane and in space, rotations and camera models, without ROS."""

from shirube_core.geometry.camera import CameraMount, PinholeCamera, gravity_aligned_camera
from shirube_core.geometry.se2 import (
    SE2,
    quaternion_from_yaw,
    rotation_matrix,
    wrap_angle,
    yaw_from_quaternion,
)
from shirube_core.geometry.se3 import SE3, matrix_from_rpy
from shirube_core.geometry.tilt_buffer import TiltBuffer

__all__ = [
    'SE2',
    'SE3',
    'CameraMount',
    'PinholeCamera',
    'TiltBuffer',
    'gravity_aligned_camera',
    'matrix_from_rpy',
    'quaternion_from_yaw',
    'rotation_matrix',
    'wrap_angle',
    'yaw_from_quaternion',
]
