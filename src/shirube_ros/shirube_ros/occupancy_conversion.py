"""Conversion of grids and paths to nav_msgs."""

from __future__ import annotations

from array import array

import numpy as np
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from numpy.typing import NDArray
from std_msgs.msg import Header

from shirube_core.geometry import SE2
from shirube_ros.pose_conversion import pose_message, pose_stamped


def occupancy_grid(
    cells: NDArray[np.int8], origin: tuple[float, float], resolution: float, header: Header
) -> OccupancyGrid:
    """Return an OccupancyGrid.

    Args:
        cells: occupancy, shape (rows, columns), row 0 at the smallest y; -1 unknown, 0 free to 100 occupied.
        origin: x and y of the lower left corner [m].
        resolution: cell size [m].
        header: stamp and frame.
    """
    rows, columns = cells.shape
    origin_pose = pose_message(SE2(*origin, 0.0))
    info = MapMetaData(
        map_load_time=header.stamp, resolution=resolution, width=columns, height=rows, origin=origin_pose
    )
    data = array('b')
    data.frombytes(np.ascontiguousarray(cells, dtype=np.int8).data.cast('B'))
    return OccupancyGrid(header=header, info=info, data=data)


def path_message(points: NDArray[np.float64], yaw_end: float, header: Header) -> Path:
    """Return a path; each pose points to the next point.

    Args:
        points: points of the path in the header's frame, shape (n, 2) [m].
        yaw_end: yaw at the end [rad].
        header: stamp and frame.
    """
    if len(points) == 0:
        return Path(header=header)
    segments = np.diff(points, axis=0)
    headings = [*np.arctan2(segments[:, 1], segments[:, 0]).tolist(), yaw_end]
    poses: list[PoseStamped] = [
        pose_stamped(SE2(x, y, yaw), header) for (x, y), yaw in zip(points.tolist(), headings, strict=True)
    ]
    return Path(header=header, poses=poses)
