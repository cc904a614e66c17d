"""The node over DDS."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest
from arbiter_graph import START, Robot, seconds_of
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from memory_tf import MemoryTf
from node_testing import isolated_graph
from rclpy.node import Node

from pose_arbiter.core.arbiter import LocalizationStatus
from shirube_core.geometry import SE2
from shirube_ros.message_conversion import pose_with_covariance_stamped


def test_two_sources_and_odometry_become_one_pose_fifty_times_a_second(graph):
    robot = Robot(graph)
    robot.drive(2.0)
    stamps = [seconds_of(pose) for pose in robot.poses]
    assert np.diff(stamps) == pytest.approx(0.02, abs=1e-6)
    assert stamps[-1] == pytest.approx(robot.now, abs=0.021)
    for pose, message in list(zip(robot.poses, robot.odometry))[10:]:
        assert pose.header.frame_id == message.header.frame_id == 'map'
        assert message.child_frame_id == 'base_link'
        assert pose.pose.position.x == pytest.approx(0.5 * (seconds_of(pose) - START), abs=0.01)
        assert message.pose.covariance[0] > 0.0
        assert message.twist.twist.linear.x == 0.5


def test_the_diagnostics_list_used_and_rejected_sources_and_odometry_carries_on_without_them(graph):
    robot = Robot(graph)
    robot.drive(1.0)
    assert robot.report().level == DiagnosticStatus.OK
    robot.drive(1.5, b=lambda pose: SE2(pose.x, pose.y + 1.0, pose.yaw))
    report = robot.report()
    assert report.level == DiagnosticStatus.WARN
    assert 'a used, b rejected (' in report.message
    values = {value.key: value.value for value in report.values}
    assert int(values['a: used']) > 20
    assert values['b received'] == '25'
    robot.drive(2.0, a=False, b=False)
    assert robot.poses[-1].pose.position.x == pytest.approx(robot.pose.x, abs=0.02)
    report = robot.report()
    assert report.level == DiagnosticStatus.WARN
    assert 'odometry only' in report.message
    assert 'a no message for' in report.message


def test_a_lost_pose_is_logged_and_not_published(graph, capfd):
    robot = Robot(graph)
    robot.drive(1.0)
    for _ in range(30):
        robot.tick(0.1)
    assert graph.spin_until(lambda: robot.node._report._status is LocalizationStatus.LOST)
    graph.spin_until(lambda: False, 0.5)
    count = len(robot.poses)
    robot.tick(0.1)
    graph.spin_until(lambda: False, 0.5)
    assert len(robot.poses) == count
    report = robot.report()
    assert report.level == DiagnosticStatus.ERROR
    assert 'pose lost' in report.message
    assert 'LOST' in capfd.readouterr().err


def test_a_person_can_say_where_the_robot_is_and_reset_forgets_it(graph):
    robot = Robot(graph)
    robot.tick(0.1)
    robot.publish_odometry()
    initial_pose = pose_with_covariance_stamped(SE2(2.0, 3.0, 1.0), np.eye(3) * 0.01, robot.header())
    robot.send('initialpose', initial_pose)
    robot.tick(0.1)
    assert graph.spin_until(lambda: bool(robot.poses))
    assert robot.poses[-1].pose.position.y == pytest.approx(3.0, abs=0.1)
    answer = robot.call_reset()
    assert (answer.success, answer.message) == (True, 'pose reset')
    count = len(robot.poses)
    robot.tick(0.1)
    graph.spin_until(lambda: False, 0.2)
    assert len(robot.poses) == count
    robot.drive(0.5)
    assert len(robot.poses) > count


def test_a_silent_source_gets_the_area_of_the_others_once_and_again_after_a_kidnapping(graph):
    robot, areas = Robot(graph, initialpose_for='b'), []
    robot.robot.create_subscription(PoseWithCovarianceStamped, '/pose_arbiter/initialpose', areas.append, 10)
    assert graph.spin_until(lambda: robot.robot.count_publishers('/pose_arbiter/initialpose') == 1)
    robot.drive(1.5)
    assert not areas
    robot.drive(2.0, b=False)
    assert len(areas) == 1
    place, covariance = areas[0].pose.pose.position, areas[0].pose.covariance
    assert place.x == pytest.approx(0.5 * (seconds_of(areas[0]) - START), abs=0.02)
    assert covariance[0] == covariance[35] == pytest.approx(0.05**2)
    robot.drive(3.0, a=lambda pose: SE2(pose.x, pose.y + 2.0, pose.yaw), b=False)
    assert len(areas) == 2
    assert areas[1].pose.pose.position.y == pytest.approx(2.0, abs=0.05)


def test_the_transform_joins_map_and_odometry(graph, monkeypatch):
    tf = MemoryTf(monkeypatch)
    robot = Robot(graph)
    robot.drive(1.0)
    (last,) = tf.published['/tf'][-1].transforms
    assert (last.header.frame_id, last.child_frame_id) == ('map', 'odom')
    assert last.transform.translation.x == pytest.approx(-5.0, abs=0.02)
    assert last.transform.translation.y == pytest.approx(-5.0, abs=0.02)
    assert seconds_of(last) == pytest.approx(robot.now + 0.1, abs=0.03)


def test_a_source_in_another_frame_is_taken_by_tf_but_not_through_the_own_transform(graph, monkeypatch):
    tf = MemoryTf(monkeypatch)
    tf.join('hall', 'map', (1.0, 0.0, 0.0))
    tf.join('map', 'odom', (0.0, 0.0, 0.0))
    robot = Robot(graph)
    publish = robot.publish_a
    robot.publish_a = lambda _: publish(SE2(1.0, 0.0, 0.0) @ robot.pose, frame='hall')
    robot.drive(1.0)
    assert robot.refusals('a') == []
    assert robot.poses[-1].pose.position.x == pytest.approx(robot.pose.x, abs=0.02)
    publish(frame='odom')
    (reason,) = robot.refusals('a')
    assert "frame_id 'odom', expected 'map'" in reason


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.newest_set_only
def test_it_ends_in_peace(number):
    with isolated_graph() as graph:
        domain = graph.context.get_domain_id()
        program = subprocess.Popen(
            [sys.executable, '-m', 'pose_arbiter.node'],
            env=os.environ | {'ROS_DOMAIN_ID': str(domain)},
            start_new_session=True,
        )
        try:
            watcher = graph.add(lambda **options: Node('watcher', **options))
            assert graph.spin_until(lambda: watcher.count_publishers('/pose_arbiter/pose') == 1, timeout=60.0)
            program.send_signal(number)
            assert program.wait(timeout=30.0) == 0
        finally:
            program.kill()
