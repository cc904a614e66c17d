"""Roll and pitch from IMU messages."""

from __future__ import annotations

import math
from typing import Any

from shirube_ros.message_error import PoseError

_SHORTEST_QUATERNION = 0.1


def tilt_from_imu(message: Any, topic: str) -> tuple[float, float]:
    """Return fixed-axis roll and pitch of a sensor_msgs/Imu [rad].

    Raises:
        PoseError: the message has no orientation, or one that is not finite.
    """
    if message.orientation_covariance[0] < 0.0:
        raise PoseError(f'{topic} has no orientation; filter it with imu_filter_madgwick or similar')
    return tilt_from_quaternion(message.orientation, topic)


def tilt_from_quaternion(message: Any, topic: str) -> tuple[float, float]:
    """Return fixed-axis roll and pitch of a geometry_msgs/Quaternion [rad].

    Raises:
        PoseError: a number is not finite, or the length is zero.
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
