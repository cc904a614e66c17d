"""Planar poses, rotations and camera models, without ROS."""

from shirube_geometry.camera_mount import CameraMount
from shirube_geometry.gravity_aligned_camera import GravityAlignedCamera, gravity_aligned_camera
from shirube_geometry.pinhole_camera import PinholeCamera
from shirube_geometry.planar_pose import PlanarPose, wrap_angle
from shirube_geometry.rotation import matrix_from_rpy, quaternion_from_yaw, yaw_from_quaternion
from shirube_geometry.tilt_buffer import TiltBuffer

__all__ = [
    'CameraMount',
    'GravityAlignedCamera',
    'PinholeCamera',
    'PlanarPose',
    'TiltBuffer',
    'gravity_aligned_camera',
    'matrix_from_rpy',
    'quaternion_from_yaw',
    'wrap_angle',
    'yaw_from_quaternion',
]
