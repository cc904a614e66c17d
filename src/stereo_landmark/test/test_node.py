"""Tests of the node through real topics."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion
from landmark_robot import Robot, header, info
from located_pairs import with_fix, without_fix
from node_testing import IsolatedGraph
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_srvs.srv import Trigger
from taught_wall import CALIBRATIONS, HERE, T_MAP_PLACE, TAUGHT, seen, write_files
from visualization_msgs.msg import Marker, MarkerArray

from shirube_core.geometry import SE2
from shirube_ros.camera.image import image_from_array
from shirube_ros.pose_conversion import planar_pose


@pytest.fixture(scope='module')
def places(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_files(tmp_path_factory.mktemp('wall')).places


def test_a_robot_that_came_back_is_localized(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places, is_real=True, map_frame='hall', base_frame='body')
    pictures = robot.listen(Image, 'debug_image')
    with_covariance = robot.listen(PoseWithCovarianceStamped, 'pose_with_covariance')
    robot.send_pair(12.5, seen(HERE))
    robot.wait_for(robot.displacements)
    robot.wait_for(robot.poses)
    robot.wait_for(with_covariance)
    (displacement,) = robot.displacements
    assert displacement.header == header(12.5, 'wall')
    assert displacement.child_frame_id == 'body'
    moved, turned = displacement.transform.translation, displacement.transform.rotation
    assert (moved.x, moved.y, moved.z) == pytest.approx(HERE[:3], abs=0.01)
    assert 2.0 * math.atan2(turned.z, turned.w) == pytest.approx(HERE[3], abs=0.01)
    T_map_base = T_MAP_PLACE @ SE2(HERE[0], HERE[1], HERE[3])
    assert robot.poses[0].header == header(12.5, 'hall')
    assert planar_pose(robot.poses[0].pose, '').distance_to(T_map_base) < 0.01
    assert with_covariance[0].header == header(12.5, 'hall')
    robot.wait_for(pictures)
    assert pictures[0].header == header(12.5, 'left_optical_frame')


def test_a_tilted_and_raised_robot_is_localized(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places, is_real=True)
    roll, pitch = 0.04, -0.03
    x, y, z, w = Rotation.from_euler('xyz', (roll, pitch, 0.0)).as_quat().tolist()
    leaning = Quaternion(x=x, y=y, z=z, w=w)
    robot.send('imu', Imu(header=header(4.98, 'base_link'), orientation=leaning))
    robot.send_pair(5.0, seen((0.15, -0.1, 0.05, 0.06, roll, pitch)))
    robot.wait_for(robot.displacements)
    moved = robot.displacements[0].transform.translation
    assert (moved.x, moved.y, moved.z) == pytest.approx((0.15, -0.1, 0.05), abs=0.01)


def test_the_covariance_is_turned_into_the_map(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places)
    with_covariance = robot.listen(PoseWithCovarianceStamped, 'pose_with_covariance')
    robot.stream.answer = with_fix()
    robot.send_pair()
    robot.wait_for(with_covariance)
    covariance = np.array(with_covariance[0].pose.covariance).reshape(6, 6)
    cos, sin = math.cos(T_MAP_PLACE.yaw), math.sin(T_MAP_PLACE.yaw)
    assert covariance[0, 0] == pytest.approx(cos**2 * 1e-6 + sin**2 * 4e-6)
    assert covariance[0, 1] == pytest.approx(cos * sin * (1e-6 - 4e-6))
    assert covariance[5, 5] == pytest.approx(1e-4)


def test_a_place_that_is_not_in_the_map_gives_only_the_displacement(
    graph: IsolatedGraph, places: Path
) -> None:
    robot = Robot(graph, places)
    robot.stream.answer = with_fix(in_map=False)
    robot.send_pair()
    robot.wait_for(robot.displacements, 2)
    assert robot.poses == []


def test_no_fix_publishes_nothing_and_says_why(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places)
    robot.stream.answer = without_fix()
    robot.send_pair()
    report = robot.report()
    assert (report.level, report.message) == (DiagnosticStatus.WARN, 'no fix: no similar shapes in view')
    assert robot.displacements == robot.poses == []


@pytest.mark.parametrize(('is_approximate', 'pairs'), [(False, 0), (True, 1)])
def test_stamps_that_differ_a_little_pair_when_that_is_asked_for(
    graph: IsolatedGraph, places: Path, is_approximate: bool, pairs: int
) -> None:
    robot = Robot(graph, places, is_real=True, approximate_sync=is_approximate)
    robot.send_pair(3.0, later=0.004)
    robot.send_pair(4.0)
    robot.wait_for(robot.displacements, pairs + 1)
    assert [each.header.stamp.sec for each in robot.displacements] == [3, 4][1 - pairs :]


def test_the_node_survives_every_bad_message(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places)
    image = seen(TAUGHT)[0]
    robot.send_pair(1.0)
    robot.send('left/image_rect', Image(encoding='bayer_rggb8', width=376, height=240, step=376))
    robot.send('left/image_rect', image_from_array(image[:100], header(1.1, '')))
    truncated = image_from_array(image, header(1.1, ''))
    truncated.data = truncated.data[:1000]
    robot.send('left/image_rect', truncated)
    robot.send('left/image_rect', image_from_array(image, header(0.9, '')))
    robot.send('left/camera_info', CameraInfo(width=376, height=240))
    robot.send('left/image_rect', image_from_array(image, header(1.2, '')))
    robot.send('imu', Imu(orientation=Quaternion(x=math.nan)))
    robot.stream.answer = ZeroDivisionError()
    robot.send_pair(1.3)
    counts = robot.node._guard.counts
    topics = ('left/image_rect', 'left/camera_info', 'right/image_rect', 'imu')
    assert [counts[topic].rejected.total() for topic in topics] == [6, 1, 1, 1]
    robot.stream.answer = with_fix()
    robot.send_pair(1.4)
    robot.wait_for(robot.poses, 2)


def test_wrong_pairs_and_cameras_are_reported_in_the_diagnostics(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places, is_real=True, queue_size=2)
    left, right = seen(TAUGHT)
    robot.send_pair(1.0, (right, left))
    assert 'left and right are swapped' in robot.report().message
    robot.send('right/camera_info', info(CALIBRATIONS[0]))
    robot.send('left/image_rect', image_from_array(left, header(2.0, '')))
    robot.send('right/image_rect', image_from_array(right, header(2.0, '')))
    assert 'baseline is 0 m, it must be positive' in robot.report().message
    robot.send('right/camera_info', info(CALIBRATIONS[1]))
    for stamp in (3.0, 3.1, 3.2):
        robot.send('left/image_rect', image_from_array(left, header(stamp, '')))
        robot.send('right/image_rect', image_from_array(right, header(stamp + 0.05, '')))
    assert 'no stamps in common' in robot.report().message
    assert robot.displacements == []


def test_tilt_and_relocalize_reach_the_stream(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places)
    leaning = Quaternion(x=math.sin(0.05), w=math.cos(0.05))
    robot.send('imu', Imu(header=header(3.5, 'base_link'), orientation=leaning))
    client = robot.robot.create_client(Trigger, '/stereo_landmark/relocalize')
    assert graph.spin_until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    assert graph.spin_until(answer.done)
    assert answer.result().success
    assert robot.stream.calls == [('tilt', 3.5, pytest.approx(0.1), pytest.approx(0.0)), ('drop_prior',)]


def test_queued_imu_readings_are_processed_before_the_pair(graph: IsolatedGraph, places: Path) -> None:
    """In callback order the reading at a pair's stamp would be processed many pairs later."""
    robot = Robot(graph, places)
    leaning = Quaternion(x=math.sin(0.05), w=math.cos(0.05))
    for number in range(50):
        message = Imu(header=header(3.0 + 0.01 * number, 'base_link'), orientation=leaning)
        robot._publishers['imu'].publish(message)
    robot.send_pair(3.49)
    kinds = [call[0] for call in robot.stream.calls]
    assert kinds.index('image') >= 45


def test_a_reading_after_a_jump_back_reaches_the_new_stream(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places)
    for stamp in (100.0, 5.0):
        robot.send('imu', Imu(header=header(stamp, 'base_link'), orientation=Quaternion(w=1.0)))
    assert [[call[:2] for call in stream.calls] for stream in robot.streams] == [
        [('tilt', 100.0)],
        [('tilt', 5.0)],
    ]


def test_found_and_lost_places_are_logged_once(
    graph: IsolatedGraph, places: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(graph, places)
    lines: list[str] = []
    may_print = [True, False, False, True]

    class Logger:
        def info(self, line: str, **_: Any) -> bool:
            lines.append(line)
            return may_print[len(lines) - 1]

    monkeypatch.setattr(robot.node, 'get_logger', Logger)
    for number, pair in enumerate((with_fix(), with_fix(), without_fix(), without_fix(), without_fix())):
        robot.stream.answer = pair
        robot.send_pair(1.0 + number)
    assert [line[:6] for line in lines] == ['at wal', 'at no ', 'at no ', 'at no ']


def test_pictures_and_markers_are_made_for_listeners(graph: IsolatedGraph, places: Path) -> None:
    robot = Robot(graph, places)
    pictures, markers = robot.listen(Image, 'debug_image'), robot.listen(MarkerArray, 'targets')
    robot.stream.answer = with_fix()
    robot.send_pair()
    robot.wait_for(pictures)
    robot.wait_for(markers)
    assert (pictures[0].encoding, pictures[0].width) == ('bgr8', 376)
    shown = [marker for marker in markers[0].markers if marker.action == Marker.ADD]
    assert [(marker.ns, marker.text, len(marker.points)) for marker in shown] == [
        ('points', '', 4),
        ('names', 'meters', 0),
    ]
    assert {marker.header.frame_id for marker in markers[0].markers} == {'base_link'}
