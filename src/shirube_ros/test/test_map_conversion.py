"""Grids, paths and clouds to messages and back."""

import math

import numpy as np
import pytest
from node_testing import cloud_from_points
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from shirube_ros.errors import PointCloudError
from shirube_ros.message_conversion import occupancy_grid, path_message, planar_pose, points_from_cloud


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


POINTS = np.random.default_rng(1).normal(size=(35, 3)).astype(np.float32)


def padded_cloud() -> PointCloud2:
    """A cloud of 5 x 7 points as double numbers in other places, with gaps after points and rows."""
    kind = np.dtype({'names': ['z', 'x', 'y'], 'formats': ['<f8'] * 3, 'offsets': [4, 12, 20], 'itemsize': 32})
    rows = np.zeros((5, 8), dtype=kind)
    for axis, name in enumerate('xyz'):
        rows[name][:, :7] = POINTS[:, axis].reshape(5, 7)
    fields = [
        PointField(name=name, offset=offset, datatype=PointField.FLOAT64, count=1)
        for name, offset in (('z', 4), ('x', 12), ('y', 20))
    ]
    return PointCloud2(height=5, width=7, fields=fields, point_step=32, row_step=256, data=rows.tobytes())


def test_points_come_back() -> None:
    points = POINTS.copy()
    points[3, 1] = np.nan
    message = cloud_from_points(points, Header(frame_id='a'))
    np.testing.assert_array_equal(points_from_cloud(message, 'points'), points)
    assert (message.header.frame_id, message.is_dense) == ('a', False)
    assert points_from_cloud(cloud_from_points(points[:0], Header()), 'points').shape == (0, 3)


def test_gaps_and_double_numbers_are_understood() -> None:
    np.testing.assert_array_equal(points_from_cloud(padded_cloud(), 'points'), POINTS)


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'is_bigendian': True}, 'bytes in the other order'),
        ({'fields': []}, 'no field x'),
        ({'point_step': 12}, 'too small'),
        ({'row_step': 100}, 'too small'),
        ({'height': 6}, 'truncated'),
        ({'fields': [PointField(name='x', datatype=PointField.INT16, count=1)]}, 'no float type'),
    ],
)
def test_clouds_that_do_not_fit_are_refused(change: dict[str, object], words: str) -> None:
    message = padded_cloud()
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(PointCloudError, match=words):
        points_from_cloud(message, 'points')
