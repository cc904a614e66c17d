"""A cloud says the same in the robot's frame as in the camera's."""

from __future__ import annotations

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from reward_planner.inputs.points_input import PointsInput
from shirube_geometry import CameraMount
from shirube_ros.message_guard import MessageGuard
from shirube_ros.point_cloud_conversion import cloud_from_points

MOUNT = CameraMount((0.2, 0.1, 0.5), (-1.7, 0.1, -1.4))


def test_clouds_in_both_frames_are_the_same_points(graph):
    host = graph.add(lambda **options: Node('host', **options))
    guard = MessageGuard(host)
    frames = []
    PointsInput(host, guard, MOUNT, 'base_link', lambda _, frame: frames.append(frame))
    camera = graph.add(lambda **options: Node('camera', **options))
    publisher = camera.create_publisher(PointCloud2, 'points', 10)
    assert graph.spin_until(lambda: publisher.get_subscription_count() == 1)
    in_camera = np.random.default_rng(1).uniform(-1.0, 3.0, (50, 3)).astype(np.float32)
    in_base = (in_camera @ MOUNT.rotation.T + MOUNT.xyz).astype(np.float32)
    for points, name in ((in_camera, 'head_optical_frame'), (in_base, 'base_link')):
        publisher.publish(cloud_from_points(points, Header(frame_id=name)))
    assert graph.spin_until(lambda: len(frames) == 2)
    for frame in frames:
        np.testing.assert_allclose(frame.points, in_camera, atol=1e-5)
