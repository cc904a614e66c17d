"""Maps and routes as messages."""

import math

import numpy as np
import pytest
from std_msgs.msg import Header

from shirube_ros.map_conversion import occupancy_grid, path_message
from shirube_ros.pose_conversion import planar_pose


def test_cells_keep_their_places() -> None:
    cells = np.array([[-1, 0, 100], [0, 50, -1]], dtype=np.int8)
    grid = occupancy_grid(cells, (-2.0, 1.5), 0.1, Header(frame_id='map'))
    assert list(grid.data) == [-1, 0, 100, 0, 50, -1]
    assert (grid.info.width, grid.info.height, grid.header.frame_id) == (3, 2, 'map')
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == (-2.0, 1.5)
    assert grid.info.origin.orientation.w == 1.0
    assert grid.info.resolution == pytest.approx(0.1)


def test_a_route_heads_for_its_next_point() -> None:
    points = np.array([(0.0, 0.0), (1.0, 1.0), (1.0, 3.0)])
    path = path_message(points, -1.0, Header(frame_id='map'))
    poses = [planar_pose(pose.pose, '') for pose in path.poses]
    np.testing.assert_array_equal([(pose.x, pose.y) for pose in poses], points)
    assert [pose.yaw for pose in poses] == pytest.approx([math.pi / 4.0, math.pi / 2.0, -1.0])
    assert path_message(points[:0], 0.0, Header()).poses == []
