"""What the simulated sensors send, as messages of rclpy."""

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
from shirube_geometry import PinholeCamera

START_SECONDS = 1000
"""What ROS's clock shows when the mission's time is 0; 0 would mean that there is no clock yet [s]."""

_TILT_VARIANCES = (1e-6, 1e-6, float(np.pi**2))
"""Of roll, pitch and yaw, which the inertial unit does not know [rad^2]."""


def stamp_of(milliseconds: int) -> Time:
    """Return a time of the mission [ms] as ROS's clock shows it."""
    seconds, rest = divmod(milliseconds, 1000)
    return Time(sec=START_SECONDS + seconds, nanosec=1_000_000 * rest)


def mission_time(stamp: Time) -> float:
    """Return the mission's time of a stamp [s]."""
    return float(stamp.sec - START_SECONDS + 1e-9 * stamp.nanosec)


def depth_image(depth: NDArray[np.float32], header: Header) -> Image:
    """Return depths, shape (height, width) [m], as an image of 32FC1."""
    height, width = depth.shape
    data = array('B')
    data.frombytes(np.ascontiguousarray(depth).data.cast('B'))
    return Image(
        header=header, height=height, width=width, encoding='32FC1', is_bigendian=0, step=4 * width, data=data
    )


def camera_info(camera: PinholeCamera, header: Header, baseline: float = 0.0) -> CameraInfo:
    """Return the calibration of a rectified camera.

    Args:
        camera: its intrinsics.
        header: of its image.
        baseline: how far to the right of the pair's left camera it is [m].
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
    """Return a reading of the tilt: roll and pitch; rates and accelerations are not told."""
    x, y, z, w = Rotation.from_euler('xyz', (reading.roll, reading.pitch, 0.0)).as_quat().tolist()
    nothing = np.array([-1.0, *[0.0] * 8])
    return Imu(
        header=header,
        orientation=Quaternion(x=x, y=y, z=z, w=w),
        orientation_covariance=np.diag(_TILT_VARIANCES).ravel(),
        angular_velocity_covariance=nothing,
        linear_acceleration_covariance=nothing,
    )
