"""Conversion of simulated sensor data to messages."""

from __future__ import annotations

from array import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Quaternion
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import Header

from scene_simulator.tilt_sensor import TiltReading
from shirube_core.geometry import PinholeCamera

START_SECONDS = 1000
"""ROS time at mission time 0 [s]; not 0, which means that simulated time has not started."""

_TILT_VARIANCES = (1e-6, 1e-6, float(np.pi**2))
"""Variances of roll, pitch and yaw, which the IMU does not measure [rad^2]."""


def stamp_of(milliseconds: int) -> Time:
    """Return the ROS stamp of a mission time [ms]."""
    seconds, rest = divmod(milliseconds, 1000)
    return Time(sec=START_SECONDS + seconds, nanosec=1_000_000 * rest)


def mission_time(stamp: Time) -> float:
    """Return the mission time of a stamp [s]."""
    return float(stamp.sec - START_SECONDS + 1e-9 * stamp.nanosec)


def depth_image(depth: NDArray[np.float32], header: Header) -> Image:
    """Return a depth image, shape (height, width) [m], as a 32FC1 message."""
    height, width = depth.shape
    data = array('B')
    data.frombytes(np.ascontiguousarray(depth).data.cast('B'))
    return Image(
        header=header, height=height, width=width, encoding='32FC1', is_bigendian=0, step=4 * width, data=data
    )


def camera_info(camera: PinholeCamera, header: Header, baseline: float = 0.0) -> CameraInfo:
    """Return the calibration of a rectified camera.

    Args:
        camera: intrinsics of the camera.
        header: header of the image.
        baseline: distance to the right of the left camera of the pair [m].
    """
    projection = np.column_stack([camera.matrix, (-camera.fx * baseline, 0.0, 0.0)])
    return CameraInfo(
        header=header,
        height=camera.height,
        width=camera.width,
        distortion_model='plumb_bob',
        d=list(camera.distortion),
        k=camera.matrix.ravel(),
        r=np.eye(3).ravel(),
        p=projection.ravel(),
    )


def imu(reading: TiltReading, header: Header) -> Imu:
    """Return an IMU message with roll and pitch, without rates and accelerations."""
    x, y, z, w = Rotation.from_euler('xyz', (reading.roll, reading.pitch, 0.0)).as_quat().tolist()
    nothing = np.array([-1.0, *[0.0] * 8])
    return Imu(
        header=header,
        orientation=Quaternion(x=x, y=y, z=z, w=w),
        orientation_covariance=np.diag(_TILT_VARIANCES).ravel(),
        angular_velocity_covariance=nothing,
        linear_acceleration_covariance=nothing,
    )
