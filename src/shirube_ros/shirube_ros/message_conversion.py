"""Conversion of messages: poses, maps and scans to and from the types of the cores."""

import math
import sys
from array import array
from typing import Any, NamedTuple

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion
from nav_msgs.msg import MapMetaData, OccupancyGrid, Odometry, Path
from numpy.typing import ArrayLike, NDArray
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from std_msgs.msg import Header

from shirube_core.geometry import SE2, quaternion_from_yaw, yaw_from_quaternion
from shirube_ros.errors import PointCloudError, PoseError, ScanError

_PLANAR = np.ix_([0, 1, 5], [0, 1, 5])  # x, y and yaw among x, y, z, roll, pitch, yaw
_SHORTEST_QUATERNION = 0.1


def pose_message(pose: SE2) -> Pose:
    """Return a pose on the floor, z = 0."""
    x, y, z, w = quaternion_from_yaw(pose.yaw)
    return Pose(position=Point(x=pose.x, y=pose.y), orientation=Quaternion(x=x, y=y, z=z, w=w))


def pose_with_covariance_message(pose: SE2, covariance: ArrayLike) -> PoseWithCovariance:
    """Return a pose on the floor with its covariance of (x, y, yaw), shape (3, 3); the rest is 0."""
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
    yaw = yaw_from_quaternion(*_unit_quaternion(message.orientation, topic))
    if not (math.isfinite(message.position.x) and math.isfinite(message.position.y)):
        raise PoseError(f'{topic} holds a pose that is not finite; check its publisher')
    return SE2(message.position.x, message.position.y, yaw)


def _unit_quaternion(message: Quaternion, topic: str) -> tuple[float, float, float, float]:
    """Return x, y, z, w; raise a PoseError for numbers that are not finite, or all zero."""
    length = math.hypot(message.x, message.y, message.z, message.w)
    if not math.isfinite(length):
        raise PoseError(f'{topic} holds an orientation that is not finite; check its publisher')
    if length < _SHORTEST_QUATERNION:
        raise PoseError(f'{topic} holds a quaternion of zeros; its publisher must set w to 1 for no rotation')
    return message.x / length, message.y / length, message.z / length, message.w / length


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
    """Return fixed-axis roll and pitch of a sensor_msgs/Imu [rad]; raise a PoseError without orientation."""
    if message.orientation_covariance[0] < 0.0:
        raise PoseError(f'{topic} has no orientation; filter it with imu_filter_madgwick or similar')
    return tilt_from_quaternion(message.orientation, topic)


def tilt_from_quaternion(message: Any, topic: str) -> tuple[float, float]:
    """Return fixed-axis roll and pitch [rad]; raise a PoseError for an invalid quaternion."""
    x, y, z, w = _unit_quaternion(message, topic)
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))


def occupancy_grid(
    cells: NDArray[np.int8], origin: tuple[float, float], resolution: float, header: Header
) -> OccupancyGrid:
    """Return an OccupancyGrid with a lower left corner x, y [m] and a cell size [m].

    The cells have shape (rows, columns), row 0 at the smallest y; -1 is unknown, 0 free to 100 occupied.
    """
    rows, columns = cells.shape
    origin_pose = Pose(position=Point(x=origin[0], y=origin[1]))
    info = MapMetaData(
        map_load_time=header.stamp, resolution=resolution, width=columns, height=rows, origin=origin_pose
    )
    data = array('b')
    data.frombytes(np.ascontiguousarray(cells, dtype=np.int8).data.cast('B'))
    return OccupancyGrid(header=header, info=info, data=data)


def path_message(points: NDArray[np.float64], yaw_end: float, header: Header) -> Path:
    """Return a path of points, shape (n, 2) [m]; each points to the next, the last to ``yaw_end`` [rad]."""
    if len(points) == 0:
        return Path(header=header)
    segments = np.diff(points, axis=0)
    headings = [*np.arctan2(segments[:, 1], segments[:, 0]).tolist(), yaw_end]
    poses: list[PoseStamped] = [
        pose_stamped(SE2(x, y, yaw), header) for (x, y), yaw in zip(points.tolist(), headings, strict=True)
    ]
    return Path(header=header, poses=poses)


_TYPES: dict[int, np.dtype[np.floating]] = {
    PointField.FLOAT32: np.dtype(np.float32),
    PointField.FLOAT64: np.dtype(np.float64),
}
_BYTES = 4


def points_from_cloud(message: PointCloud2, topic: str) -> NDArray[np.float32]:
    """Return the points of a cloud with float fields x, y and z, shape (n, 3), in its frame [m], also NaN.

    Raises:
        PointCloudError: a coordinate is missing or no float, wrong byte order, or data that does not match the size.
    """
    if message.is_bigendian != (sys.byteorder == 'big'):
        raise PointCloudError(f'{topic} has bytes in the other order; let its publisher send little endian')
    offsets, kinds = zip(*(_field(message, name, topic) for name in 'xyz'), strict=True)
    width, height = message.width, message.height
    step, row_step = message.point_step, message.row_step
    ends = [offset + kind.itemsize for offset, kind in zip(offsets, kinds, strict=True)]
    if width * height == 0:
        return np.empty((0, 3), dtype=np.float32)
    if step < max(ends) or row_step < width * step:
        raise PointCloudError(f'{topic} has point_step or row_step too small for its fields; correct its publisher')
    if len(message.data) < row_step * (height - 1) + width * step:
        raise PointCloudError(f'{topic} is truncated; check its publisher and the network')
    points = np.empty((height, width, 3), dtype=np.float32)
    for axis, (offset, kind) in enumerate(zip(offsets, kinds, strict=True)):
        points[..., axis] = np.ndarray(
            (height, width), kind, buffer=message.data, offset=offset, strides=(row_step, step)
        )
    return points.reshape(-1, 3)


def _field(message: PointCloud2, name: str, topic: str) -> tuple[int, np.dtype[np.floating]]:
    """Return offset and type of a coordinate."""
    for field in message.fields:
        if field.name == name:
            if field.datatype not in _TYPES:
                raise PointCloudError(f'{topic} has {name} in no float type; send float32')
            return field.offset, _TYPES[field.datatype]
    raise PointCloudError(f'{topic} has no field {name}; send x, y and z')


class ScanRays(NamedTuple):
    """Ends of the rays in the frame of the scan, shape (n, 3) [m], NaN where unknown, and which of them hit."""

    ends: NDArray[np.float32]
    is_hit: NDArray[np.bool_]


def rays_from_scan(message: LaserScan, topic: str) -> ScanRays:
    """Return the rays of a scan.

    REP 117: -inf is too close to measure, an obstacle at range_min; +inf is nothing within range_max, free up to there;
    NaN is unknown. Finite ranges outside of the limits are unknown, too, as LaserScan defines them.

    Raises:
        ScanError: limits or angles that are not finite or contradict each other.
    """
    low, high, first, step = (
        float(value) for value in (message.range_min, message.range_max, message.angle_min, message.angle_increment)
    )
    if not all(map(math.isfinite, (low, high, first, step))) or step == 0.0:
        raise ScanError(f'{topic} has limits or angles that are not finite, or a step of 0; check its publisher')
    if not 0.0 <= low < high:
        raise ScanError(f'{topic} has a range_min that is not below range_max; check its publisher')
    ranges = np.array(message.ranges, dtype=np.float64)
    is_far, is_near = ranges == np.inf, ranges == -np.inf
    is_valid = (ranges >= low) & (ranges <= high)
    length = np.select([is_far, is_near, is_valid], [high, low, ranges], np.nan)
    angles = first + step * np.arange(len(ranges))
    ends = np.column_stack([length * np.cos(angles), length * np.sin(angles), 0.0 * length])
    return ScanRays(ends.astype(np.float32), is_near | is_valid)
