"""A cloud gives the same points in the robot's frame as in the camera's."""

from __future__ import annotations

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from reward_planner.interface.sensor_inputs import PointsInput
from shirube_core.geometry import CameraMount
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.point_cloud_conversion import cloud_from_points

MOUNT = CameraMount((0.2, 0.1, 0.5), (-1.7, 0.1, -1.4))


class Input:
    """The input in a node, and a camera that publishes clouds."""

    def __init__(self, graph, camera_frame=''):
        self._graph, self.frames = graph, []
        host = graph.add(lambda **options: Node('host', **options))
        self.guard = CallbackGuard(host)
        names = ('base_link', camera_frame)
        PointsInput(host, self.guard, MOUNT, names, lambda _, frame: self.frames.append(frame))
        camera = graph.add(lambda **options: Node('camera', **options))
        self._publisher = camera.create_publisher(PointCloud2, 'points', 10)
        assert graph.spin_until(lambda: self._publisher.get_subscription_count() == 1)

    def send(self, points, name):
        before = self.guard.counts['points'].received
        self._publisher.publish(cloud_from_points(points, Header(frame_id=name)))
        assert self._graph.spin_until(lambda: self.guard.counts['points'].received > before)


IN_CAMERA = np.random.default_rng(1).uniform(-1.0, 3.0, (50, 3)).astype(np.float32)


def test_clouds_in_both_frames_are_the_same_points(graph):
    given = Input(graph)
    in_base = (IN_CAMERA @ MOUNT.rotation.T + MOUNT.xyz).astype(np.float32)
    for points, name in ((IN_CAMERA, 'head_optical_frame'), (in_base, 'base_link')):
        given.send(points, name)
    assert len(given.frames) == 2
    for frame in given.frames:
        np.testing.assert_allclose(frame.points, IN_CAMERA, atol=1e-5)


def test_clouds_of_another_camera_are_refused_with_one_line(graph):
    given = Input(graph)
    for name in ('base_link', 'head_optical_frame', 'rear_optical_frame', 'head_optical_frame', 'base_link'):
        given.send(IN_CAMERA, name)
    assert len(given.frames) == 4
    ((line, count),) = given.guard.counts['points'].rejected.items()
    assert line.startswith(
        "points is in the frame 'rear_optical_frame', the camera with this mount is 'head_optical"
    )
    assert (count, '\n' in line) == (1, False)


def test_the_camera_may_be_named_however_its_frame_ends(graph):
    given = Input(graph, 'head')
    for name in ('rear_optical_frame', 'head'):
        given.send(IN_CAMERA, name)
    assert len(given.frames) == 1
