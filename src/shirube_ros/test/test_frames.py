"""Mounts and poses from parameters and from a TF in memory."""

import math

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseWithCovarianceStamped
from memory_tf import MemoryTf
from node_testing import IsolatedGraph
from rclpy.node import Node
from std_msgs.msg import Header

from shirube_core.geometry import SE2, CameraMount
from shirube_ros import frames as frames_module
from shirube_ros.errors import FrameError
from shirube_ros.frames import Frames
from shirube_ros.message_conversion import pose_with_covariance_stamped

DEFAULT = CameraMount()
CAMERA = 'belly_camera_optical_frame'
# On a bracket that is turned to the left.
EXPECTED = CameraMount((0.2 - 0.05, 0.1, 0.3), (math.pi, 0.0, 0.0))
REFUSAL = 'goal is in x; publish it in map'


@pytest.fixture
def tf(monkeypatch: pytest.MonkeyPatch) -> MemoryTf:
    return MemoryTf(monkeypatch)


def frames_of(graph: IsolatedGraph, **parameters: object) -> Frames:
    return Frames(graph.add(lambda **options: Node('localizer', **options), **parameters), 'base_link')


def at(seconds: int, frame: str = CAMERA) -> Header:
    return Header(stamp=Time(sec=seconds), frame_id=frame)


def join_camera(tf: MemoryTf, *, is_static: bool = True) -> None:
    tf.join('base_link', 'bracket', (0.2, 0.1, 0.2), (0.0, 0.0, math.pi / 2.0), is_static=is_static)
    tf.join('bracket', CAMERA, (0.0, 0.05, 0.1), (math.pi, 0.0, -math.pi / 2.0))


def assert_same(found: CameraMount, expected: CameraMount) -> None:
    np.testing.assert_allclose(found.xyz, expected.xyz, atol=1e-12)
    np.testing.assert_allclose(found.rotation, expected.rotation, atol=1e-12)


def test_tf_gives_the_mount_through_all_its_frames(graph: IsolatedGraph, tf: MemoryTf) -> None:
    join_camera(tf)
    assert_same(frames_of(graph).mount(at(10), DEFAULT), EXPECTED)


@pytest.mark.parametrize('given', [{'camera_xyz': [0.0, 0.0, 0.13]}, {'camera_rpy': [math.pi, 0.0, 0.0]}])
def test_parameters_win_even_with_the_default_and_are_published(
    graph: IsolatedGraph, tf: MemoryTf, given: dict[str, list[float]]
) -> None:
    join_camera(tf)
    frames = frames_of(graph, **given)
    for _ in range(3):
        assert frames.mount(at(10), DEFAULT) is DEFAULT
    (message,) = tf.published['/tf_static']
    (sent,) = message.transforms
    assert (sent.header.frame_id, sent.child_frame_id) == ('base_link', CAMERA)
    tf.join('base_link', 'sent', (0.0, 0.0, 0.0))
    translation, rotation = sent.transform.translation, sent.transform.rotation
    assert (translation.x, translation.y, translation.z) == DEFAULT.xyz
    assert abs(rotation.x) == pytest.approx(abs(rotation.y))  # pi, 0, -pi / 2
    # A second camera is published with the first; a change while running, again.
    frames.mount(at(10, 'other'), DEFAULT)
    assert [each.child_frame_id for each in tf.published['/tf_static'][-1].transforms] == [CAMERA, 'other']
    frames.mount(at(10), EXPECTED)
    assert len(tf.published['/tf_static']) == 3


def test_what_tf_has_already_is_not_published_again(graph: IsolatedGraph, tf: MemoryTf) -> None:
    tf.join('base_link', CAMERA, DEFAULT.xyz, DEFAULT.rpy)
    assert frames_of(graph, camera_xyz=[0.0, 0.0, 0.13]).mount(at(10), DEFAULT) is DEFAULT
    assert tf.published['/tf_static'] == []


def test_a_value_set_while_running_wins(graph: IsolatedGraph, tf: MemoryTf) -> None:
    join_camera(tf)
    frames = frames_of(graph)
    frames.mount(at(10), DEFAULT)
    tuned = CameraMount((0.0, 0.0, 0.14))
    assert frames.mount(at(11), tuned) is tuned


def test_the_default_serves_only_if_tf_stays_without_the_camera(
    graph: IsolatedGraph, tf: MemoryTf, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    frames = frames_of(graph)
    with pytest.raises(FrameError, match=f"no transform from '{CAMERA}' to 'base_link'"):
        frames.mount(at(10), DEFAULT)
    monkeypatch.setattr(frames_module, '_STARTUP', -1.0)
    for _ in range(2):
        assert frames.mount(at(10), DEFAULT) is DEFAULT
    assert capfd.readouterr().err.count('the default is used') == 1
    join_camera(tf)
    assert_same(frames.mount(at(11), DEFAULT), EXPECTED)


def test_an_image_newer_than_tf_is_refused(graph: IsolatedGraph, tf: MemoryTf, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frames_module, '_STARTUP', -1.0)
    join_camera(tf, is_static=False)
    tf.latest = 10.5
    frames = frames_of(graph)
    assert_same(frames.mount(at(10), DEFAULT), EXPECTED)
    with pytest.raises(FrameError, match='at the stamp'):
        frames.mount(at(11), DEFAULT)


def test_without_tf_the_parameters_serve(graph: IsolatedGraph, capfd: pytest.CaptureFixture[str]) -> None:
    frames = frames_of(graph)
    for _ in range(2):
        assert frames.mount(at(10), DEFAULT) is DEFAULT
    words = capfd.readouterr().err
    assert words.count('tf2_ros is not installed') == words.count('the default is used') == 1
    with pytest.raises(FrameError, match=f'^{REFUSAL}$'):
        frames.to('map', at(10, 'odom'), REFUSAL)
    assert frames.pose_to('map', at(10, 'map'), SE2(1.0, 2.0, 3.0), REFUSAL) == SE2(1.0, 2.0, 3.0)


def test_poses_and_their_covariances_turn_with_the_frame(graph: IsolatedGraph, tf: MemoryTf) -> None:
    tf.join('map', 'odom', (1.0, 2.0, 0.0), (0.0, 0.0, math.pi / 2.0), is_static=False)
    tf.latest = 10.0
    frames = frames_of(graph)
    message = pose_with_covariance_stamped(SE2(3.0, 0.0, 0.1), np.diag([1.0, 4.0, 9.0]), at(10, 'odom'))
    assert isinstance(message, PoseWithCovarianceStamped)
    pose, covariance = frames.pose_with_covariance_to('map', message, 'initialpose', REFUSAL)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 5.0, math.pi / 2.0 + 0.1))
    np.testing.assert_allclose(covariance, np.diag([4.0, 1.0, 9.0]), atol=1e-12)
    # Later than TF: only an operator's pose is taken, with the latest transform.
    message.header.stamp.sec = 11
    with pytest.raises(FrameError, match=f'^{REFUSAL} .TF has no transform'):
        frames.pose_with_covariance_to('map', message, 'initialpose', REFUSAL)
    late, _ = frames.pose_with_covariance_to('map', message, 'initialpose', REFUSAL, is_latest_valid=True)
    assert late == pose
    with pytest.raises(FrameError):
        frames.pose_to('map', at(10, 'nowhere'), SE2(0.0, 0.0, 0.0), REFUSAL, is_latest_valid=True)
