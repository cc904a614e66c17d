"""Grids and routes as messages of nav_msgs."""

from __future__ import annotations

from array import array

import numpy as np
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from numpy.typing import NDArray
from std_msgs.msg import Header

from shirube_geometry import quaternion_from_yaw


def occupancy_grid(
    cells: NDArray[np.int8], origin: tuple[float, float], resolution: float, header: Header
) -> OccupancyGrid:
    """Return a map.

    Args:
        cells: shape (rows, columns), row 0 the lowest; -1 unknown, 0 to 100 occupied.
        origin: x and y of the lower left corner [m].
        resolution: side of a cell [m].
        header: stamp and frame.
    """
    rows, columns = cells.shape
    place = Pose(position=Point(x=origin[0], y=origin[1]), orientation=Quaternion(w=1.0))
    info = MapMetaData(
        map_load_time=header.stamp, resolution=resolution, width=columns, height=rows, origin=place
    )
    data = array('b')
    data.frombytes(np.ascontiguousarray(cells, dtype=np.int8).data.cast('B'))
    return OccupancyGrid(header=header, info=info, data=data)


def path_message(points: NDArray[np.float64], yaw_end: float, header: Header) -> Path:
    """Return a route; each pose heads for the next point.

    Args:
        points: shape (n, 2), in the header's frame [m].
        yaw_end: heading at the end [rad].
        header: stamp and frame.
    """
    if len(points) == 0:
        return Path(header=header)
    ways = np.diff(points, axis=0)
    headings = [*np.arctan2(ways[:, 1], ways[:, 0]).tolist(), yaw_end]
    poses = [
        PoseStamped(header=header, pose=_pose(x, y, yaw))
        for (x, y), yaw in zip(points.tolist(), headings, strict=True)
    ]
    return Path(header=header, poses=poses)


def _pose(x: float, y: float, yaw: float) -> Pose:
    qx, qy, qz, qw = quaternion_from_yaw(yaw)
    return Pose(position=Point(x=x, y=y), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))
