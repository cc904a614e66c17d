"""Conversion of grids, paths and point clouds to messages and back."""

import sys
from array import array

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseStamped
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from shirube_core.geometry import SE2
from shirube_ros.errors import PointCloudError
from shirube_ros.pose_conversion import pose_stamped


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
    """Return a path of points, shape (n, 2) [m]; each pose points to the next one, the last to ``yaw_end``
    [rad].
    """
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
    """Return the points of a cloud with float fields x, y and z, shape (n, 3), in its frame [m]; NaN stays
    NaN.

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
