"""The node on real topics, with a fake tracker that records its calls."""

import math
import os
import subprocess
import sys
from dataclasses import replace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from floor_views import CAMERA, MOUNT
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from localizer_results import COVARIANCE, POSE, REASON, a_fix, no_fix
from memory_tf import MemoryTf
from nav_msgs.msg import Odometry
from node_testing import IsolatedGraph, NodeUser, header, run_in_process
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker, MarkerArray

from floor_localizer.core.fix import Fix, NoFix
from floor_localizer.localization.visualization import delete_markers, dot_markers
from floor_localizer.node import FloorLocalizerNode, main
from shirube_core.geometry import SE2, PinholeCamera
from shirube_ros.camera.image import image_from_array
from shirube_ros.message_conversion import odometry_message, planar_pose, pose_with_covariance_stamped

PIXELS = np.random.default_rng(4).integers(0, 256, (235, 235), dtype=np.uint8)
INFO = CameraInfo(width=235, height=235, k=[339.44, 0.0, 117.0, 0.0, 339.44, 117.0, 0.0, 0.0, 1.0])


class FakeTracker:
    """Records its calls and returns a preset answer."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.answer: Fix | NoFix | Exception = a_fix()

    def add_odometry(self, stamp: float, T_odom_base: SE2) -> None:
        self.calls.append(('odometry', stamp, T_odom_base))

    def set_area(self, T_map_base: SE2, covariance: np.ndarray, level: str) -> None:
        self.calls.append(('area', T_map_base, covariance, level))

    def relocalize(self) -> None:
        self.calls.append(('relocalize',))

    def track(self, stamp: float, image: np.ndarray, camera: PinholeCamera) -> Fix | NoFix:
        self.calls.append(('track', stamp, image, camera))
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer


class Robot(NodeUser):
    """The node under test and a node that simulates the rest of the robot."""

    def __init__(self, graph: IsolatedGraph, **parameters: Any) -> None:
        self._graph = graph
        self.trackers: list[FakeTracker] = []
        self.node = graph.add(self._make_node, **parameters)
        self.robot = graph.add(lambda **options: Node('robot', **options))
        inputs = {'image_raw': Image, 'camera_info': CameraInfo, 'odom': Odometry}
        inputs['initialpose'] = PoseWithCovarianceStamped
        self.publishers = {name: self.robot.create_publisher(inputs[name], name, 10) for name in inputs}
        self.poses = self.listen(PoseStamped, 'pose')
        self.reports: list[DiagnosticStatus] = []
        self.robot.create_subscription(
            DiagnosticArray, '/diagnostics', lambda array: self.reports.extend(array.status), 10
        )
        assert graph.spin_until(self._is_connected)

    def _make_node(self, **options: Any) -> FloorLocalizerNode:
        def create_tracker(*_: object) -> FakeTracker:
            self.trackers.append(FakeTracker())
            return self.trackers[-1]

        return FloorLocalizerNode(lambda *_: None, create_tracker, **options)  # type: ignore[arg-type, return-value]

    def _is_connected(self) -> bool:
        topics = ('/floor_localizer/pose', '/diagnostics')
        counts = [publisher.get_subscription_count() for publisher in self.publishers.values()]
        return {*counts, *(self.robot.count_publishers(topic) for topic in topics)} == {1}

    @property
    def tracker(self) -> FakeTracker:
        return self.trackers[-1]

    def send_image(self, stamp: float = 10.0) -> None:
        self.send('camera_info', INFO)
        self.send('image_raw', image_from_array(PIXELS, header(stamp, 'belly_optical_frame')))


def values_of(report: DiagnosticStatus) -> dict[str, str]:
    return {value.key: value.value for value in report.values}


def odometry(stamp: float, pose: SE2 = POSE, child_frame: str = 'base_link') -> Odometry:
    return odometry_message(pose, COVARIANCE, header(stamp, 'odom'), child_frame)


def test_a_fix_is_published_with_the_stamp_of_its_image_in_the_map_frame(graph):
    robot = Robot(graph, map_frame='hall')
    with_covariance = robot.listen(PoseWithCovarianceStamped, 'pose_with_covariance')
    robot.send_image(12.5)
    robot.wait_for(robot.poses)
    robot.wait_for(with_covariance)
    for message in (robot.poses[0], with_covariance[0]):
        assert message.header == header(12.5, 'hall')
    assert planar_pose(robot.poses[0].pose, '').distance_to(POSE) < 1e-12
    covariance = np.array(with_covariance[0].pose.covariance).reshape(6, 6)
    assert covariance.diagonal() == pytest.approx([1e-8, 4e-8, 0.0, 0.0, 0.0, 1e-6])
    _, stamp, pixels, camera = robot.tracker.calls[0]
    assert stamp == pytest.approx(12.5)
    np.testing.assert_array_equal(pixels, PIXELS)
    assert camera == CAMERA


def test_no_fix_publishes_nothing_and_says_why(graph):
    robot = Robot(graph)
    robot.tracker.answer = no_fix()
    robot.send_image(10.0)
    report = robot.report()
    assert (report.level, report.message) == (DiagnosticStatus.WARN, f'no fix: {REASON.value}')
    robot.tracker.answer = a_fix()
    robot.send_image(10.1)
    robot.wait_for(robot.poses)
    assert [message.header.stamp.nanosec for message in robot.poses] == [100_000_000]


def test_the_node_survives_every_bad_message(graph):
    robot = Robot(graph)
    nowhere = SE2(math.nan, 0.0, 0.0)
    robot.send_image(1.0)
    robot.send('image_raw', Image(encoding='bayer_rggb8', width=235, height=235, step=235))
    robot.send('image_raw', image_from_array(PIXELS[:100], header(1.1, '')))
    robot.send('image_raw', image_from_array(PIXELS, header(0.9, '')))
    robot.send('camera_info', CameraInfo(width=235, height=235))
    robot.send('image_raw', image_from_array(PIXELS, header(1.2, '')))
    robot.send('odom', odometry(1.0, nowhere))
    robot.send('odom', odometry(1.0, child_frame='arm'))
    robot.send('initialpose', pose_with_covariance_stamped(nowhere, COVARIANCE, header(1.0, 'map')))
    robot.send('initialpose', pose_with_covariance_stamped(POSE, COVARIANCE, header(1.0, 'odom')))
    robot.send('initialpose', PoseWithCovarianceStamped())
    robot.tracker.answer = ZeroDivisionError()
    robot.send_image(1.3)
    counts = robot.node._guard.counts
    expected = {'image_raw': 5, 'camera_info': 1, 'odom': 2, 'initialpose': 3}
    assert {topic: counts[topic].rejected.total() for topic in expected} == expected
    robot.tracker.answer = a_fix()
    robot.send_image(1.4)
    robot.wait_for(robot.poses, 2)
    expected = '1: odom holds a pose that is not finite; check its publisher'
    assert expected in [value.value for value in robot.report().values]


def test_odometry_and_area_reach_the_tracker(graph):
    robot = Robot(graph)
    robot.send('odom', odometry(3.25))
    robot.send('initialpose', pose_with_covariance_stamped(POSE, np.eye(3) * 0.2, header(3.0, 'map')))
    (kind, stamp, pose), (other_kind, area, covariance, level) = robot.tracker.calls
    assert (kind, stamp, other_kind, level) == ('odometry', 3.25, 'area', '')
    assert POSE.distance_to(pose) < 1e-12
    assert POSE.distance_to(area) < 1e-12
    np.testing.assert_array_equal(covariance, np.eye(3) * 0.2)


def test_a_pose_on_a_level_is_in_the_frame_of_the_level(graph):
    robot = Robot(graph)
    robot.tracker.answer = replace(a_fix(), level='ground')
    robot.send_image(10.0)
    robot.wait_for(robot.poses)
    assert robot.poses[0].header.frame_id == 'map/ground'
    robot.send('initialpose', pose_with_covariance_stamped(POSE, np.eye(3) * 0.2, header(3.0, 'map/ground')))
    assert robot.tracker.calls[-1][3] == 'ground'
    assert values_of(robot.report())['level'] == 'ground'


def test_a_jump_back_in_time_starts_a_new_tracker(graph):
    robot = Robot(graph)
    robot.send('odom', odometry(100.0))
    robot.send_image(100.0)
    for stamp in (4.8, 4.9):
        robot.send('odom', odometry(stamp))
    robot.send_image(4.9)
    robot.send_image(5.0)
    robot.send('odom', odometry(5.0))
    assert [[call[:2] for call in tracker.calls] for tracker in robot.trackers] == [
        [('odometry', 100.0), ('track', 100.0)],
        [('track', 5.0), ('odometry', 5.0)],
    ]


def test_the_service_drops_the_prior(graph):
    robot = Robot(graph)
    client = robot.robot.create_client(Trigger, '/floor_localizer/relocalize')
    assert graph.spin_until(client.service_is_ready)
    future = client.call_async(Trigger.Request())
    assert graph.spin_until(future.done)
    assert future.result().success
    assert robot.tracker.calls == [('relocalize',)]


def test_pictures_and_dots_are_made_for_listeners(graph):
    robot = Robot(graph)
    pictures, dots = robot.listen(Image, 'debug_image'), robot.listen(MarkerArray, 'dots')
    robot.send_image()
    robot.wait_for(pictures)
    robot.wait_for(dots)
    assert (pictures[0].encoding, pictures[0].width) == ('bgr8', 235)
    assert pictures[0].header == header(10.0, 'belly_optical_frame')
    assert [len(marker.points) for marker in dots[0].markers] == [2, 1]


def test_each_dot_is_a_marker_as_large_whose_image_is_the_dot():
    fix = a_fix()
    markers = dot_markers(fix, CAMERA, MOUNT, header(0.0, 'map')).markers
    assert {marker.header.frame_id for marker in markers} == {'map'}
    for marker, chosen in zip(markers, (fix.matched, ~fix.matched), strict=True):
        points_base = POSE.inverse().transform([(point.x, point.y) for point in marker.points])
        pixels = CAMERA.pixels_from_points(MOUNT.camera_points_from_floor(points_base))
        np.testing.assert_allclose(pixels, fix.dots.pixels[chosen], atol=1e-6)
        assert marker.scale.x == pytest.approx(8.0 * 0.09 / 235.0, rel=0.01)
    # Without a fix the old markers go away.
    assert [marker.action for marker in delete_markers(header(0.0)).markers] == [Marker.DELETEALL]


@pytest.mark.parametrize(('parameters', 'name'), [
    ({}, 'demo floor (no map_file given)'), ({'map_file': 'hall.csv'}, 'hall.csv')
])  # fmt: skip
def test_without_a_map_the_demo_floor_is_announced(graph, capfd, parameters, name):
    assert values_of(Robot(graph, **parameters).report())['map'] == name
    assert ('NO MAP GIVEN' in capfd.readouterr().err) == (not parameters)


@pytest.mark.parametrize(('parameter', 'expected'), [
    ('map_file:=/no/such/map.csv', '/no/such/map.csv'), ('match_rate_min:=7.0', 'match_rate_min is 7.0'),
    ('map_fil:=/no/such/map.csv', 'did you mean map_file?'),
    ('camera_xyz:=[0.0, 0.0, -0.13]', 'camera_xyz: z is -0.13 m'),
])  # fmt: skip
def test_a_bad_start_is_one_line_and_exit_code_1(capfd, parameter, expected):
    assert run_in_process(main, '--ros-args', '-p', parameter) == 1
    lines = capfd.readouterr().err.splitlines()
    (line,) = (line for line in lines if not line.startswith(('[INFO]', '[WARN]')))
    assert expected in line


@pytest.mark.newest_set_only
def test_a_refused_parameter_is_all_that_is_said():
    command = [sys.executable, '-m', 'floor_localizer.node', '--ros-args', '-p', 'match_rate_min:=7.0']
    environment = os.environ | {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    program = subprocess.run(command, env=environment, capture_output=True, timeout=60, check=False)
    assert len(program.stderr.splitlines()) == 1


def test_the_mount_is_that_of_tf(graph, monkeypatch):
    tf, localizer = MemoryTf(monkeypatch), Mock()
    tf.join('base_link', 'belly_optical_frame', (0.1, 0.0, 0.2), MOUNT.rpy)
    robot = Robot(graph)
    robot.node._localizer, robot.tracker.apply_settings = Mock(), Mock()
    monkeypatch.setattr('floor_localizer.node.FloorLocalizer', localizer)
    for stamp in (10.0, 10.1):
        robot.send_image(stamp)
    (call,) = localizer.call_args_list
    assert call.args[1].xyz == pytest.approx((0.1, 0.0, 0.2))
    assert robot.tracker.apply_settings.call_count == 1
