"""Conversion of planar poses and the tilt of the base to messages and back."""

import math
from typing import Any

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion
from nav_msgs.msg import Odometry
from numpy.typing import ArrayLike, NDArray
from std_msgs.msg import Header

from shirube_core.geometry import SE2, quaternion_from_yaw, yaw_from_quaternion
from shirube_ros.errors import PoseError

_PLANAR = np.ix_([0, 1, 5], [0, 1, 5])  # x, y and yaw among x, y, z, roll, pitch, yaw
_SHORTEST_QUATERNION = 0.1


def pose_message(pose: SE2) -> Pose:
    """Return a pose on the floor, z = 0."""
    x, y, z, w = quaternion_from_yaw(pose.yaw)
    return Pose(position=Point(x=pose.x, y=pose.y), orientation=Quaternion(x=x, y=y, z=z, w=w))


def pose_with_covariance_message(pose: SE2, covariance: ArrayLike) -> PoseWithCovariance:
    """Return a pose on the floor with its covariance of (x, y, yaw), shape (3, 3); z, roll and pitch have
    zeros.
    """
    full = np.zeros((6, 6))
    full[_PLANAR] = covariance
    return PoseWithCovariance(pose=pose_message(pose), covariance=full.ravel())


def pose_stamped(pose: SE2, header: Header) -> PoseStamped:
    """Return the pose of a robot in the header's frame."""
    return PoseStamped(header=header, pose=pose_message(pose))


def pose_with_covariance_stamped(pose: SE2, covariance: ArrayLike, header: Header) -> PoseWithCovarianceStamped:
    """Return the pose of a robot in the header's frame with its covariance, shape (3, 3), of (x, y, yaw)."""
    return PoseWithCovarianceStamped(header=header, pose=pose_with_covariance_message(pose, covariance))


def odometry_message(pose: SE2, covariance: ArrayLike, header: Header, child_frame: str) -> Odometry:
    """Return odometry without a twist: the pose of ``child_frame`` in the header's frame."""
    pose_part = pose_with_covariance_message(pose, covariance)
    return Odometry(header=header, child_frame_id=child_frame, pose=pose_part)


def planar_pose(message: Pose, topic: str) -> SE2:
    """Return x, y and yaw; z, roll and pitch are dropped.

    Raises:
        PoseError: a number is not finite, or the quaternion has length zero.
    """
    orientation = message.orientation
    quaternion = (orientation.x, orientation.y, orientation.z, orientation.w)
    if not all(math.isfinite(number) for number in (message.position.x, message.position.y, *quaternion)):
        raise PoseError(f'{topic} holds a pose that is not finite; check its publisher')
    length = math.hypot(*quaternion)
    if length < _SHORTEST_QUATERNION:
        raise PoseError(f'{topic} holds a quaternion of zeros; its publisher must set w to 1 for no rotation')
    x, y, z, w = (number / length for number in quaternion)
    return SE2(message.position.x, message.position.y, yaw_from_quaternion(x, y, z, w))


def base_odometry(message: Odometry, topic: str, base_frame: str) -> SE2:
    """Return ``T_odom_base``; raise a PoseError for odometry of another frame, or an invalid pose."""
    if message.child_frame_id not in ('', base_frame):
        raise PoseError(
            f'{topic} has child_frame_id {message.child_frame_id!r}, base_frame is {base_frame!r}; make them equal'
        )
    return planar_pose(message.pose.pose, topic)


def planar_pose_with_covariance(message: PoseWithCovariance, topic: str) -> tuple[SE2, NDArray[np.float64]]:
    """Return the pose on the floor and its covariance, shape (3, 3), of (x, y, yaw) [m, m, rad].

    Raises:
        PoseError: an invalid pose, or a covariance that is not finite, symmetric and positive definite.
    """
    pose = planar_pose(message.pose, topic)
    covariance = np.array(message.covariance, dtype=np.float64).reshape(6, 6)[_PLANAR]
    if (
        not np.isfinite(covariance).all()
        or not (
            np.abs(covariance - covariance.T) <= 1e-8 + 1e-5 * np.abs(covariance)  # np.allclose takes twice as long
        ).all()
    ):
        raise PoseError(f'{topic} holds a covariance that is not finite and symmetric; check its publisher')
    if np.linalg.eigvalsh(covariance)[0] <= 0.0:
        raise PoseError(
            f'{topic} holds a covariance that is not positive definite for x, y and yaw; set it in its publisher'
        )
    return pose, covariance


def tilt_from_imu(message: Any, topic: str) -> tuple[float, float]:
    """Return fixed-axis roll and pitch of a sensor_msgs/Imu [rad]; raise a PoseError without a finite
    orientation.
    """
    if message.orientation_covariance[0] < 0.0:
        raise PoseError(f'{topic} has no orientation; filter it with imu_filter_madgwick or similar')
    return tilt_from_quaternion(message.orientation, topic)


def tilt_from_quaternion(message: Any, topic: str) -> tuple[float, float]:
    """Return fixed-axis roll and pitch [rad]; raise a PoseError if a number is not finite, or the length is
    zero.
    """
    numbers = (message.x, message.y, message.z, message.w)
    length = math.hypot(*numbers)
    if not math.isfinite(length):
        raise PoseError(f'{topic} holds an orientation that is not finite; check its publisher')
    if length < _SHORTEST_QUATERNION:
        raise PoseError(f'{topic} holds a quaternion of zeros; its publisher must set w to 1 for no rotation')
    x, y, z, w = (number / length for number in numbers)
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
