"""Points of clouds and of three cameras."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from l_rig import BASELINE, CAMERA, picture, projection, true_depth
from memory_tf import MemoryTf
from node_testing import cloud_from_points
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Header

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.settings import DepthSettings
from reward_planner.interface.sensor_inputs import PointsInput, TrinocularInput
from reward_planner.node_settings import NodeSettings
from shirube_core.geometry import CameraMount
from shirube_ros.callback_guard import CallbackGuard
from shirube_ros.camera.image import image_from_array
from shirube_ros.frames import Frames

MOUNT = CameraMount((0.2, 0.1, 0.5), (-1.7, 0.1, -1.4))


class Input:
    """The input in a node, and a camera that publishes clouds."""

    def __init__(self, graph, camera_frame=''):
        self._graph, self.frames = graph, []
        host = graph.add(lambda **options: Node('host', **options))
        self.guard = CallbackGuard(host)
        settings = NodeSettings(camera_xyz=MOUNT.xyz, camera_rpy=MOUNT.rpy, camera_frame=camera_frame)
        frames = Frames(host, 'base_link')
        PointsInput(host, self.guard, settings, frames, lambda _, frame: self.frames.append(frame))
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


def test_a_cloud_in_any_frame_of_tf_is_the_same_points_from_its_sensor(graph, monkeypatch):
    tf, at = MemoryTf(monkeypatch), CameraMount((-0.3, 0.0, 1.1), (0.0, 0.0, 2.0))
    tf.join('base_link', 'laser', at.xyz, at.rpy)
    given = Input(graph)
    in_base = IN_CAMERA @ MOUNT.rotation.T + MOUNT.xyz
    given.send(((in_base - at.xyz) @ at.rotation).astype(np.float32), 'laser')
    (frame,) = given.frames
    assert frame.mount.xyz == pytest.approx(at.xyz)
    np.testing.assert_allclose(frame.points @ frame.mount.rotation.T + frame.mount.xyz, in_base, atol=1e-5)
    given.send(IN_CAMERA, 'attic')
    assert len(given.frames) == 1
    (reason,) = given.guard.counts['points'].rejected
    assert "TF has no transform from 'attic'" in reason


@pytest.mark.parametrize('camera_frame', ['', 'head'])
def test_clouds_of_another_camera_are_refused_with_one_line(graph, camera_frame):
    given, camera = Input(graph, camera_frame), camera_frame or 'head_optical_frame'
    for name in ('base_link', camera, 'rear_optical_frame', camera, 'base_link'):
        given.send(IN_CAMERA, name)
    assert len(given.frames) == 4
    ((line, count),) = given.guard.counts['points'].rejected.items()
    assert line.startswith(f"points is in the frame 'rear_optical_frame', the camera with this mount is '{camera}")
    assert (count, '\n' in line) == (1, False)


PLACES = {'left': (0.0, 0.0), 'right': (BASELINE, 0.0), 'top': (0.0, -BASELINE)}


class Rig:
    """A node with the input, and three cameras."""

    def __init__(self, graph):
        self._graph = graph
        self.host = graph.add(lambda **options: Node('host', **options))
        self.guard = CallbackGuard(self.host, (RewardPlannerError,))
        self.frames = []
        settings = NodeSettings(image_transport='raw', depth=DepthSettings(disparities=48))
        self.input = TrinocularInput(self.host, self.guard, settings, lambda *both: self.frames.append(both))
        cameras = graph.add(lambda **options: Node('cameras', **options))
        self._publishers = {
            f'{name}/{topic}': cameras.create_publisher(kind, f'{name}/{topic}', 10)
            for name in PLACES
            for topic, kind in (('image_rect', Image), ('camera_info', CameraInfo))
        }
        assert graph.spin_until(lambda: all(p.get_subscription_count() == 1 for p in self._publishers.values()))

    def send(self, topic, message):
        before = self.guard.counts[topic].received
        self._publishers[topic].publish(message)
        assert self._graph.spin_until(lambda: self.guard.counts[topic].received > before)

    def send_info(self, name, place=None):
        p = projection(CAMERA, *(place or PLACES[name]))
        info = CameraInfo(width=CAMERA.width, height=CAMERA.height, k=CAMERA.matrix.ravel(), p=p.ravel())
        self.send(f'{name}/camera_info', info)

    def send_image(self, name, sec):
        header = Header(stamp=Time(sec=sec), frame_id=f'{name}_optical_frame')
        self.send(f'{name}/image_rect', image_from_array(picture(*PLACES[name]), header))


def test_three_images_become_points(graph):
    rig = Rig(graph)
    for name in PLACES:
        rig.send_info(name)
    rig.send_image('right', 4)
    for name in ('top', 'left', 'right'):
        rig.send_image(name, 5)
    ((header, frame),) = rig.frames
    assert (header.stamp.sec, header.frame_id) == (5, 'left_optical_frame')
    assert frame.focal_length == CAMERA.fx
    assert rig.input.groups.dropped == 1
    assert len(frame.points) > 0.8 * CAMERA.width * CAMERA.height
    x, y, z = frame.points.T
    columns = np.round(x / z * CAMERA.fx + CAMERA.cx).astype(int)
    rows = np.round(y / z * CAMERA.fy + CAMERA.cy).astype(int)
    wrong = np.abs(1.0 / z - 1.0 / true_depth()[rows, columns]) * CAMERA.fx * BASELINE > 1.0
    assert wrong.mean() < 0.06


@pytest.mark.parametrize('name', ['right', 'top'])
def test_a_rig_without_a_baseline_is_refused(graph, name):
    rig = Rig(graph)
    for other in PLACES:
        rig.send_info(other, (0.0, 0.0) if other == name else None)
    for other in PLACES:
        rig.send_image(other, 5)
    assert rig.frames == []
    (line,) = rig.guard.counts['top/image_rect'].rejected
    assert 'there is no baseline' in line
