"""The node through real topics, with a receiver that records its inputs; resets and errors at the start."""

import json
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from beacon_robot import LEANING, NOWHERE, PIXELS, Robot, odometry
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, Quaternion, QuaternionStamped, Twist, TwistStamped
from node_testing import IsolatedGraph, header, run_in_process
from receptions import ACCEPTED, LAMPS, MOVED, POSE, REFUSED, TOO_FAR, with_fix, without_fix
from sensor_msgs.msg import CameraInfo, Image, Imu
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from shirube_core.geometry import SE2, PinholeCamera
from shirube_ros.camera.image import image_from_array
from shirube_ros.message_conversion import planar_pose
from vlc_beacon.core.packet.command_packet import Operation
from vlc_beacon.node import main

BEACONS = 'beacons: [{id: 1, xyz: [0, 0, 2.5], radius: 0.03}, {id: 2, xyz: [1, 0, 2.5], radius: 0.03}]'
Start = Callable[..., Robot]


@pytest.fixture
def start(graph: IsolatedGraph, tmp_path: Path) -> Start:
    """Starts the node under test, which knows two lamps, with parameters, and a robot around it."""
    (tmp_path / 'beacons.yaml').write_text(BEACONS)
    return partial(Robot, graph, tmp_path / 'beacons.yaml')


def test_a_fix_is_published_with_the_stamp_of_its_image_in_the_map_frame(start: Start) -> None:
    robot = start(map_frame='hall')
    assert robot.robot.count_publishers('/vlc_beacon/cmd_vel') == 0
    with_covariance = robot.listen(PoseWithCovarianceStamped, 'pose_with_covariance')
    robot.send_image(12.5)
    robot.wait_for(robot.poses)
    robot.wait_for(with_covariance)
    for message in (robot.poses[0], with_covariance[0]):
        assert message.header == header(12.5, 'hall')
    assert planar_pose(robot.poses[0].pose, '').distance_to(POSE) < 1e-12
    covariance = np.array(with_covariance[0].pose.covariance).reshape(6, 6)
    assert covariance.diagonal() == pytest.approx([1e-6, 4e-6, 0.0, 0.0, 0.0, 1e-4])
    _, stamp, pixels, camera = robot.receiver.calls[0]
    assert stamp == pytest.approx(12.5)
    np.testing.assert_array_equal(pixels, PIXELS)
    assert camera == PinholeCamera(160, 100, 100.0, 100.0, 80.0, 50.0)


def test_no_fix_publishes_nothing_and_reports_the_reason(start: Start) -> None:
    robot = start()
    robot.receiver.answer = without_fix()
    robot.send_image(10.0)
    report = robot.report()
    assert (report.level, report.message) == (DiagnosticStatus.WARN, 'no fix: no known lamp in view')
    robot.receiver.answer = with_fix()
    robot.send_image(10.1)
    robot.wait_for(robot.poses)
    assert [message.header.stamp.nanosec for message in robot.poses] == [100_000_000]


def test_accepted_commands_are_published_and_rejected_ones_are_not(start: Start) -> None:
    robot = start()
    commands = robot.listen(String, 'command')
    # What is worth a warning and what is not, in turn: neither keeps the other from being told.
    robot.receiver.answer = with_fix([REFUSED, TOO_FAR, REFUSED, ACCEPTED])
    robot.send_image()
    robot.wait_for(commands)
    assert [json.loads(message.data) for message in commands] == [
        {'beacon': 1, 'counter': 7, 'op': 'slow', 'value': 0.125}
    ]
    report = robot.report()
    assert (report.level, 'wrong authentication code' in report.message) == (DiagnosticStatus.WARN, True)


def test_the_robot_drives_within_the_speed_limit_and_base_frame(start: Start) -> None:
    robot = start(drive=True, speed_limit=0.02, base_frame='body')
    velocities = robot.listen(TwistStamped, 'cmd_vel')
    now = robot.node.get_clock().now().nanoseconds * 1e-9
    for step in range(30):
        robot.send_image(now + 0.05 * step)
        if len(velocities) > 4:
            break
    robot.wait_for(velocities, 4)
    speeds = [message.twist.linear.x for message in velocities]
    assert 0.0 < max(speeds) <= 0.02
    assert velocities[0].header.frame_id == 'body'
    robot.send_image(now + 0.05 * (step + 1))
    velocities.clear()
    robot.node.stop()
    # A velocity that was sent just before may arrive first.
    robot.wait_until(lambda: Twist() in [message.twist for message in velocities])


def test_the_node_survives_every_bad_message(start: Start) -> None:
    robot = start()
    robot.send_image(1.0)
    robot.send('image_raw', Image(encoding='bayer_rggb8', width=160, height=100, step=160))
    robot.send('image_raw', image_from_array(PIXELS[:50], header(1.1, '')))
    robot.send('image_raw', image_from_array(PIXELS, header(0.9, '')))
    robot.send('camera_info', CameraInfo(width=160, height=100))
    robot.send('image_raw', image_from_array(PIXELS, header(1.2, '')))
    robot.send('odom', odometry(1.0, SE2(math.nan, 0.0, 0.0)))
    robot.send('odom', odometry(1.0, child_frame='arm'))
    robot.send('imu', Imu(orientation=NOWHERE))
    robot.send('imu', Imu(orientation_covariance=[-1.0, *[0.0] * 8]))
    robot.send('attitude', QuaternionStamped(quaternion=Quaternion(w=0.0)))
    robot.receiver.answer = ZeroDivisionError()
    robot.send_image(1.3)
    counts = robot.node._guard.counts
    topics = ('image_raw', 'camera_info', 'odom', 'imu', 'attitude')
    assert [counts[topic].rejected.total() for topic in topics] == [5, 1, 2, 2, 1]
    robot.receiver.answer = with_fix()
    robot.send_image(1.4)
    robot.wait_for(robot.poses, 2)


def test_odometry_and_tilt_reach_the_receiver(start: Start) -> None:
    robot = start()
    robot.send('odom', odometry(3.25))
    robot.send('imu', Imu(header=header(3.5, 'base_link'), orientation=LEANING))
    robot.send('attitude', QuaternionStamped(header=header(3.75, 'base_link'), quaternion=LEANING))
    (*by_odometry, pose), by_imu, by_attitude = robot.receiver.calls
    assert by_odometry == ['odometry', 3.25]
    assert POSE.distance_to(pose) < 1e-12
    leaning = pytest.approx(0.1), pytest.approx(0.0)
    assert (by_imu, by_attitude) == (('tilt', 3.5, *leaning), ('tilt', 3.75, *leaning))


def test_pictures_and_markers_are_made_for_listeners(start: Start) -> None:
    robot = start()
    pictures, markers = robot.listen(Image, 'debug_image'), robot.listen(MarkerArray, 'beacons')
    robot.receiver.answer = with_fix(lamps=LAMPS, anomalies=(MOVED,))
    robot.send_image()
    robot.wait_for(pictures)
    robot.wait_for(markers)
    assert (pictures[0].encoding, pictures[0].width) == ('bgr8', 160)
    assert pictures[0].header == header(10.0, 'ceiling_optical_frame')
    marked = {(marker.ns, marker.id) for marker in markers[0].markers}
    assert marked == {('ids', 1), ('ids', 2), ('lamps', 1), ('lamps', 2)}
    assert len(markers[0].markers) == len(marked)


def test_a_jump_back_in_time_of_any_topic_starts_a_new_receiver(start: Start) -> None:
    robot = start()
    robot.send('odom', odometry(100.0))
    for back in (0.4, 0.3, 0.2, 0.1, 0.0):  # one old stamp is no jump
        robot.send('odom', odometry(50.0 - back))
    for stamp in (60.0, *(20.0 - back for back in (0.4, 0.3, 0.2, 0.1, 0.0))):
        robot.send('imu', Imu(header=header(stamp, 'base_link'), orientation=LEANING))
    for stamp in (30.0, *(5.0 - back for back in (0.4, 0.3, 0.2, 0.1, 0.0))):
        robot.send('attitude', QuaternionStamped(header=header(stamp, 'base_link'), quaternion=LEANING))
    robot.send_image(100.0)
    for back in (0.4, 0.3, 0.2, 0.1, 0.0):
        robot.send_image(4.0 - back)
    assert [[call[:2] for call in receiver.calls] for receiver in robot.receivers] == [
        [('odometry', 100.0)],
        [('odometry', 50.0), ('tilt', 60.0)],
        [('tilt', 20.0), ('tilt', 30.0)],
        [('tilt', 5.0), ('receive', 100.0)],
        [('receive', 4.0)],
    ]


@pytest.mark.parametrize('operation', [Operation.TURN, Operation.STOP])
def test_after_a_jump_back_the_line_begins_where_the_robot_is_and_a_stop_holds(start: Start, operation) -> None:
    robot = start(drive=True)
    robot.send_image(100.0)
    before = robot.node._command_executor
    before.execute(operation, 1.0 if operation is Operation.TURN else 0.0)
    for stamp in (4.6, 4.7, 4.8, 4.9, 5.0):
        robot.send_image(stamp)
    after = robot.node._command_executor
    assert after is not before
    after.update_pose(5.1, POSE)
    velocities = [after.velocity(5.1 + 0.1 * k) for k in range(3)]
    assert all(v.is_zero for v in velocities) == (operation is Operation.STOP)
    assert (max(v.forward for v in velocities) > 0.0) == (operation is Operation.TURN)


def test_a_lost_pose_is_logged_after_the_throttle_interval(start: Start, monkeypatch) -> None:
    robot = start()
    lines, may_speak = [], [True, False, True, True]

    class Logger:
        def info(self, line: str, **_: object) -> bool:
            said = may_speak.pop(0)
            lines.extend([line[:7]] if said else [])
            return said

    monkeypatch.setattr(robot.node, 'get_logger', Logger)
    for answer in (with_fix(), without_fix(), without_fix(), without_fix()):
        robot.node._log_change(answer.result)
    assert lines == ['pose: x', 'no pose']


@pytest.mark.parametrize(
    ('content', 'parameters', 'words'),
    [
        (None, (), 'beacons_file is not set'),
        ('beacons: []', (), 'holds no lamps'),
        (BEACONS, ('method:=guess',), 'method is'),
        (BEACONS, ('shuter:=rolling',), 'did you mean shutter?'),
        (BEACONS, ('camera_rpy:=[3.14, 0.0, 0.0]',), 'does not look up'),
        (BEACONS, ('key_file:=/no/such/key',), 'counter_file is not set'),
        (BEACONS, ('key_file:=/no/such/key', 'counter_file:=/tmp/counters'), '/no/such/key cannot be read'),
    ],
)
def test_a_bad_start_is_one_line_and_exit_code_1(tmp_path, content, parameters, words, capfd) -> None:
    given = list(parameters)
    if content is not None:
        (tmp_path / 'beacons.yaml').write_text(content)
        given.append(f'beacons_file:={tmp_path}/beacons.yaml')
    arguments = ['--ros-args', *(word for parameter in given for word in ('-p', parameter))] if given else []
    assert run_in_process(main, *arguments) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith('vlc_beacon: ')
    assert words in line
