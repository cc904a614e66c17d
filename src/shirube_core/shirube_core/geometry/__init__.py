"""Planar poses, rotations and camera models, without ROS."""

from shirube_core.geometry.camera_mount import CameraMount
from shirube_core.geometry.gravity_aligned_camera import GravityAlignedCamera, gravity_aligned_camera
from shirube_core.geometry.pinhole_camera import PinholeCamera
from shirube_core.geometry.rotation import matrix_from_rpy, quaternion_from_yaw, yaw_from_quaternion
from shirube_core.geometry.se2 import SE2, wrap_angle
from shirube_core.geometry.tilt_buffer import TiltBuffer

__all__ = [
    'SE2',
    'CameraMount',
    'GravityAlignedCamera',
    'PinholeCamera',
    'TiltBuffer',
    'gravity_aligned_camera',
    'matrix_from_rpy',
    'quaternion_from_yaw',
    'wrap_angle',
    'yaw_from_quaternion',
]
