"""The truth and the images of a scene as ROS messages (plain dataclasses, no ROS needed)."""

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from scene_simulator.robot.leg_drive import TiltReading
from shirube_bags.bag_reader import jazzy_types
from shirube_core.geometry import SE2, PinholeCamera, quaternion_from_yaw

_ODOMETRY_VARIANCES = (1e-4, 1e-4, 1e-12, 1e-12, 1e-12, 1e-3)
_IMU_VARIANCES = (1e-6, 1e-6, math.pi**2)  # variances of roll, pitch and (unknown) yaw [rad^2]


def compressed_image(
    image: NDArray[np.uint8], frame: str, stamp_ns: int, quality: int = 90, *, progressive: bool = False
) -> object:
    """Return a grey image, shape (height, width), as sensor_msgs/CompressedImage.

    Args:
        image: grey levels.
        frame: ``frame_id`` of the camera.
        stamp_ns: stamp [ns].
        quality: JPEG quality, up to 100.
        progressive: takes longer and makes dark images a good deal smaller.
    """
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    if progressive:
        options += [cv2.IMWRITE_JPEG_PROGRESSIVE, 1, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
    _, jpeg = cv2.imencode('.jpg', image, options)
    return _message(
        'sensor_msgs/msg/CompressedImage',
        header=_header(frame, stamp_ns),
        format='mono8; jpeg compressed ',
        data=np.asarray(jpeg, dtype=np.uint8).ravel(),
    )


def camera_info(
    camera: PinholeCamera,
    frame: str,
    stamp_ns: int,
    rotation: NDArray[np.float64] | None = None,
    projection: NDArray[np.float64] | None = None,
) -> object:
    """Return the calibration of the camera of a frame as sensor_msgs/CameraInfo.

    Args:
        camera: intrinsics of its images.
        frame: ``frame_id`` of the camera.
        stamp_ns: stamp [ns].
        rotation: shape (3, 3), into the rectified frame; none for a camera that is alone.
        projection: shape (3, 4), into the rectified image; none for a camera that is alone.
    """
    R = np.eye(3) if rotation is None else rotation
    P = np.column_stack([camera.matrix, np.zeros(3)]) if projection is None else projection
    whole_image = _message(
        'sensor_msgs/msg/RegionOfInterest', x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    return _message(
        'sensor_msgs/msg/CameraInfo',
        header=_header(frame, stamp_ns),
        height=camera.height,
        width=camera.width,
        distortion_model=camera.model.value,
        d=np.array(camera.distortion),
        k=camera.matrix.ravel(),
        r=R.ravel(),
        p=P.ravel(),
        binning_x=0,
        binning_y=0,
        roi=whole_image,
    )


def pose_stamped(pose: SE2, frame: str, stamp_ns: int) -> object:
    """Return a pose on the floor as geometry_msgs/PoseStamped in a frame."""
    return _message('geometry_msgs/msg/PoseStamped', header=_header(frame, stamp_ns), pose=_pose(pose))


def odometry(pose: SE2, velocity: tuple[float, float], stamp_ns: int) -> object:
    """Return wheel odometry as nav_msgs/Odometry.

    Args:
        pose: ``T_odom_base``.
        velocity: linear [m/s] and angular [rad/s] velocity.
        stamp_ns: stamp [ns].
    """
    forward, yaw_rate = velocity
    twist = _message('geometry_msgs/msg/Twist', linear=_vector(forward, 0.0, 0.0), angular=_vector(0.0, 0.0, yaw_rate))
    covariance = np.diag(_ODOMETRY_VARIANCES).ravel()
    return _message(
        'nav_msgs/msg/Odometry',
        header=_header('odom', stamp_ns),
        child_frame_id='base_link',
        pose=_message('geometry_msgs/msg/PoseWithCovariance', pose=_pose(pose), covariance=covariance),
        twist=_message('geometry_msgs/msg/TwistWithCovariance', twist=twist, covariance=covariance),
    )


def imu(reading: TiltReading, frame: str, stamp_ns: int) -> object:
    """Return a reading of the tilt as sensor_msgs/Imu: roll and pitch; rates and accelerations are marked unknown."""
    x, y, z, w = (float(part) for part in Rotation.from_euler('xyz', (reading.roll, reading.pitch, 0.0)).as_quat())
    # By the definition of sensor_msgs/Imu, -1 marks a missing measurement.
    nothing = np.array([-1.0, *[0.0] * 8])
    return _message(
        'sensor_msgs/msg/Imu',
        header=_header(frame, stamp_ns),
        orientation=_message('geometry_msgs/msg/Quaternion', x=x, y=y, z=z, w=w),
        orientation_covariance=np.diag(_IMU_VARIANCES).ravel(),
        angular_velocity=_vector(0.0, 0.0, 0.0),
        angular_velocity_covariance=nothing,
        linear_acceleration=_vector(0.0, 0.0, 0.0),
        linear_acceleration_covariance=nothing,
    )


def occupancy_grid(cells: NDArray[np.int8], origin: tuple[float, float], resolution: float, stamp_ns: int) -> object:
    """Return cells, shape (rows, columns), as nav_msgs/OccupancyGrid in the frame map.

    Args:
        cells: 0 free, 100 occupied.
        origin: x and y of the lower left corner of cell (0, 0) [m].
        resolution: side of a cell [m].
        stamp_ns: stamp [ns].
    """
    header = _header('map', stamp_ns)
    info = _message(
        'nav_msgs/msg/MapMetaData',
        map_load_time=_message('builtin_interfaces/msg/Time', sec=0, nanosec=0),
        resolution=resolution,
        width=cells.shape[1],
        height=cells.shape[0],
        origin=_pose(SE2(*origin, 0.0)),
    )
    return _message('nav_msgs/msg/OccupancyGrid', header=header, info=info, data=cells.ravel())


def flag(value: bool) -> object:
    """Return std_msgs/Bool."""
    return _message('std_msgs/msg/Bool', data=value)


def _message(msgtype: str, **fields: Any) -> object:
    return jazzy_types().types[msgtype](**fields)


def _header(frame: str, stamp_ns: int) -> object:
    seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
    stamp = _message('builtin_interfaces/msg/Time', sec=seconds, nanosec=nanoseconds)
    return _message('std_msgs/msg/Header', stamp=stamp, frame_id=frame)


def _pose(pose: SE2) -> object:
    x, y, z, w = quaternion_from_yaw(pose.yaw)
    return _message(
        'geometry_msgs/msg/Pose',
        position=_message('geometry_msgs/msg/Point', x=pose.x, y=pose.y, z=0.0),
        orientation=_message('geometry_msgs/msg/Quaternion', x=x, y=y, z=z, w=w),
    )


def _vector(x: float, y: float, z: float) -> object:
    return _message('geometry_msgs/msg/Vector3', x=x, y=y, z=z)
