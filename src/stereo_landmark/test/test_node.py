"""Tests of the node through real topics; its error messages for invalid parameters and files."""

import math
from functools import partial
from unittest.mock import Mock, call

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from landmark_robot import Robot, imu, info
from located_pairs import with_fix, without_fix
from node_testing import header, run_in_process
from random_places import random_images, random_place
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger
from taught_wall import CALIBRATIONS, LEANING, SIDES, T_MAP_PLACE, TAUGHT, seen, taught_place
from visualization_msgs.msg import Marker, MarkerArray

from shirube_core.geometry import SE2
from shirube_ros.camera.image import image_from_array
from shirube_ros.message_conversion import planar_pose
from stereo_landmark.core.landmark_localizer import LandmarkLocalizer
from stereo_landmark.core.settings import LandmarkSettings, SearchSettings
from stereo_landmark.core.stereo import StereoImages
from stereo_landmark.files.place_file import load_places, save_place
from stereo_landmark.node import main, validate_places
from stereo_landmark.page.pair_source import taught_pair


@pytest.fixture
def make_robot(graph, shared_files):
    return partial(Robot, graph, shared_files.places)


@pytest.fixture
def robot(make_robot):
    """A robot whose node asks fake streams."""
    return make_robot()


@pytest.mark.parametrize(('mode', 'accuracy'), [('likelihood', 0.01), ('paper', 0.02)])
def test_a_tilted_and_raised_robot_that_came_back_is_localized(make_robot, mode, accuracy):
    robot = make_robot(is_real=True, map_frame='hall', base_frame='body', mode=mode)
    pictures = robot.listen(Image, 'debug_image')
    with_covariance = robot.listen(PoseWithCovarianceStamped, 'pose_with_covariance')
    robot.send('imu', imu(header(12.48, 'body'), LEANING[4:]))
    robot.send_pair(12.5, seen(LEANING))
    for messages in (robot.displacements, robot.poses, with_covariance, pictures):
        robot.wait_for(messages)
    (displacement,) = robot.displacements
    assert displacement.header == header(12.5, 'wall')
    assert displacement.child_frame_id == 'body'
    moved, turned = displacement.transform.translation, displacement.transform.rotation
    yaw = 2.0 * math.atan2(turned.z, turned.w)
    assert (moved.x, moved.y, moved.z, yaw) == pytest.approx(LEANING[:4], abs=accuracy)
    T_map_base = T_MAP_PLACE @ SE2(LEANING[0], LEANING[1], LEANING[3])
    assert planar_pose(robot.poses[0].pose, '').distance_to(T_map_base) < 0.01
    assert robot.poses[0].header == with_covariance[0].header == header(12.5, 'hall')
    assert pictures[0].header == header(12.5, 'left_optical_frame')


def test_the_covariance_is_turned_into_the_map(robot):
    with_covariance = robot.listen(PoseWithCovarianceStamped, 'pose_with_covariance')
    robot.stream.add_image.return_value = with_fix()
    robot.send_pair()
    robot.wait_for(with_covariance)
    covariance = np.array(with_covariance[0].pose.covariance).reshape(6, 6)
    cos, sin = math.cos(T_MAP_PLACE.yaw), math.sin(T_MAP_PLACE.yaw)
    assert covariance[0, 0] == pytest.approx(cos**2 * 1e-6 + sin**2 * 4e-6)
    assert covariance[0, 1] == pytest.approx(cos * sin * (1e-6 - 4e-6))
    assert covariance[5, 5] == pytest.approx(1e-4)


def test_without_a_fix_nothing_is_published_and_without_a_map_pose_only_the_displacement(robot):
    robot.stream.add_image.return_value = without_fix()
    robot.send_pair(1.0)
    report = robot.report()
    assert (report.level, report.message) == (DiagnosticStatus.WARN, 'no fix: no similar shapes in view')
    assert robot.displacements == []
    robot.stream.add_image.return_value = with_fix(in_map=False)
    robot.send_pair(2.0)
    robot.wait_for(robot.displacements, 2)
    assert robot.poses == []


@pytest.mark.parametrize(('is_approximate', 'seconds'), [(False, [4]), (True, [3, 4])])
def test_stamps_that_differ_a_little_pair_when_that_is_asked_for(make_robot, is_approximate, seconds):
    robot = make_robot(is_real=True, approximate_sync=is_approximate)
    robot.send_pair(3.0, later=0.004)
    robot.send_pair(4.0)
    robot.wait_for(robot.displacements, len(seconds))
    assert [each.header.stamp.sec for each in robot.displacements] == seconds


def test_the_node_survives_every_bad_message(robot):
    image = seen(TAUGHT)[0]
    truncated = image_from_array(image, header(1.1, ''))
    truncated.data = truncated.data[:1000]
    robot.send_pair(1.0)
    for topic, message in (
        ('left/image_rect', Image(encoding='bayer_rggb8', width=376, height=240, step=376)),
        ('left/image_rect', image_from_array(image[:100], header(1.1, ''))),
        ('left/image_rect', truncated),
        ('left/image_rect', image_from_array(image, header(0.9, ''))),
        ('left/camera_info', CameraInfo(width=376, height=240)),
        ('left/image_rect', image_from_array(image, header(1.2, ''))),
        ('imu', imu(header(0.0, ''), (math.nan, 0.0))),
    ):
        robot.send(topic, message)
    robot.stream.add_image.side_effect = ZeroDivisionError()
    robot.send_pair(1.3)
    counts = robot.node._guard.counts
    topics = ('left/image_rect', 'left/camera_info', 'right/image_rect', 'imu')
    assert [counts[topic].rejected.total() for topic in topics] == [6, 1, 1, 1]
    robot.stream.add_image = Mock(return_value=with_fix())
    robot.send_pair(1.4)
    robot.wait_for(robot.poses, 2)


def test_wrong_pairs_and_cameras_are_reported_in_the_diagnostics(make_robot):
    robot = make_robot(is_real=True, queue_size=2)

    def send_images(stamp, later=0.0):
        for side, image, when in zip(SIDES, seen(TAUGHT), (stamp, stamp + later)):
            robot.send(f'{side}/image_rect', image_from_array(image, header(when, '')))

    robot.send_pair(1.0, seen(TAUGHT)[::-1])
    assert 'left and right are swapped' in robot.report().message
    robot.send('right/camera_info', info(CALIBRATIONS[0]))
    send_images(2.0)
    assert 'baseline is 0 m, it must be positive' in robot.report().message
    robot.send('right/camera_info', info(CALIBRATIONS[1]))
    for stamp in (3.0, 3.1, 3.2):
        send_images(stamp, 0.05)
    assert 'no stamps in common' in robot.report().message
    assert robot.displacements == []


def test_tilt_and_relocalize_reach_the_stream(graph, robot):
    robot.send('imu', imu(header(3.5, 'base_link'), (0.1, 0.0)))
    client = robot.robot.create_client(Trigger, '/stereo_landmark/relocalize')
    assert graph.spin_until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    assert graph.spin_until(answer.done)
    assert answer.result().success
    tilt = call.add_tilt(3.5, pytest.approx(0.1), pytest.approx(0.0))
    assert robot.stream.mock_calls == [tilt, call.drop_prior()]


def test_queued_imu_readings_are_processed_before_the_pair(robot):
    """In callback order the reading at a pair's stamp would be processed many pairs later."""
    for number in range(50):
        robot.publishers['imu'].publish(imu(header(3.0 + 0.01 * number, 'base_link'), (0.1, 0.0)))
    robot.send_pair(3.49)
    kinds = [name for name, *_ in robot.stream.mock_calls]
    assert kinds.index('add_image') >= 45


def test_a_reading_after_a_jump_back_reaches_the_new_stream(robot):
    for stamp in (100.0, 4.6, 4.7, 4.8, 4.9, 5.0):
        robot.send('imu', imu(header(stamp, 'base_link'), (0.0, 0.0)))
    calls = [stream.mock_calls for stream in robot.streams]
    assert calls == [[call.add_tilt(100.0, 0.0, 0.0)], [call.add_tilt(5.0, 0.0, 0.0)]]


def test_found_and_lost_places_are_logged_once(robot, monkeypatch):
    lines = []
    may_print = [True, False, False, True]

    class Logger:
        def info(self, line, **_):
            lines.append(line)
            return may_print[len(lines) - 1]

    monkeypatch.setattr(robot.node, 'get_logger', Logger)
    for number, pair in enumerate((with_fix(), with_fix(), without_fix(), without_fix(), without_fix())):
        robot.stream.add_image.return_value = pair
        robot.send_pair(1.0 + number)
    assert [line[:6] for line in lines] == ['at wal', 'at no ', 'at no ', 'at no ']


def test_pictures_and_markers_are_made_for_listeners(robot):
    pictures, markers = robot.listen(Image, 'debug_image'), robot.listen(MarkerArray, 'targets')
    robot.stream.add_image.return_value = with_fix()
    robot.send_pair()
    robot.wait_for(pictures)
    robot.wait_for(markers)
    assert (pictures[0].encoding, pictures[0].width) == ('bgr8', 376)
    shown = [marker for marker in markers[0].markers if marker.action == Marker.ADD]
    assert [marker.ns for marker in shown] == ['points', 'names']
    assert {marker.header.frame_id for marker in markers[0].markers} == {'base_link'}


@pytest.mark.parametrize(
    ('parameters', 'expected'),
    [
        ((), 'places_dir is not set'),
        (('places_dir:={folder}/wrong',), 'wrong.yaml: format is not shirube/taught_place'),
        (('place_dir:={folder}',), 'did you mean places_dir?'),
        (('places_dir:={folder}/right', 'map_frame:=wall'), 'place wall has the same name as map_frame'),
        (('places_dir:={folder}', 'queue_size:=0'), 'queue_size is 0, allowed is 1 to 1000'),
    ],
)
def test_a_bad_start_is_one_line_and_exit_code_1(tmp_path, parameters, expected, capfd):
    (tmp_path / 'wrong').mkdir()
    save_place(tmp_path / 'right', random_place(1, 'wall'), random_images(1))
    (tmp_path / 'wrong/wrong.yaml').write_text('a: 1')
    given = [word for each in parameters for word in ('-p', each.format(folder=tmp_path))]
    assert run_in_process(main, *(('--ros-args', *given) if given else ())) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith('stereo_landmark: ')
    assert expected in line


def test_a_place_that_is_not_found_in_its_own_images_is_reported(shared_files):
    folder = shared_files.places
    assert validate_places(folder, load_places(folder), LandmarkSettings()) == []
    strict = LandmarkSettings(search=SearchSettings(log_likelihood_ratio_min=100.0))
    (line,) = validate_places(folder, load_places(folder), strict)
    start = 'place wall is not found in the images it was taught from: the match could be due to chance'
    assert line.startswith(start)


def test_the_tilt_at_teaching_is_used_in_validation_and_further_teaching(tmp_path, monkeypatch):
    path = save_place(tmp_path, taught_place(), StereoImages(*seen(TAUGHT), (0.04, -0.03)))
    assert taught_pair(path).images(0).tilt == (0.04, -0.03)
    asked = []
    locate = LandmarkLocalizer.locate
    monkeypatch.setattr(LandmarkLocalizer, 'locate', lambda *given: asked.append(given[3]) or locate(*given))
    validate_places(tmp_path, load_places(tmp_path), LandmarkSettings())
    assert asked == [(0.04, -0.03)]
