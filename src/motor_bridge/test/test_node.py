"""The node through real topics, with a controller on a pseudo-terminal."""

import math
from types import SimpleNamespace

import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from node_testing import run_in_process
from rclpy.node import Node
from rclpy.parameter import Parameter

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.node import MotorBridgeNode, main
from shirube_core.settings import SettingsError
from shirube_ros import input_watch
from shirube_ros.message_conversion import planar_pose

pytestmark = pytest.mark.newest_set_only


def test_the_emergency_stop_holds_until_it_is_taken_back(robot):
    robot.drive(0.8, 0.3)
    robot.stop()
    robot.until(lambda: robot.send(0.3) or robot.is_stopped())  # still commanded, so only the stop can do it
    robot.drive(0.4, 0.3)
    assert robot.is_stopped()
    assert robot.message().message == 'stopped by estop'
    robot.stop(is_on=False)
    robot.drive(0.8, 0.3)
    assert robot.is_driving()


@pytest.mark.parametrize('lost_ends', [0, 1])
def test_the_robot_stops_when_the_node_ends_even_if_the_line_lost_the_end_of_a_command(robot, lost_ends):
    robot.drive(0.8, 0.3)
    if lost_ends:
        robot.fault('lost_cr', lost_ends)
    robot.node.stop()
    assert robot.controller._firmware.pwm == (0, 0)


def test_the_robot_goes_on_after_faults_and_odometry_stays_right(robot):
    robot.drive(0.8, 0.2, 0.3)
    for fault in (('garbage', 3), ('wrong', 5), ('lost_cr', 1), ('silence', 0.3)):
        robot.fault(*fault)
        robot.drive(1.2, 0.2, 0.3)
        assert robot.is_driving(), fault
    assert robot.error() < 3e-3


def test_the_robot_goes_on_when_it_is_plugged_in_again(robot):
    # Slowly: it drives on until the auto-stop, and no count measures its motion there.
    robot.drive(0.8, 0.15)
    robot.fault('unplug', 1.2)  # longer than the period of the diagnostics
    robot.until(lambda: not robot.report.is_connected)
    assert 'connect the controller' in robot.message().message
    robot.until(lambda: robot.report.is_connected)
    robot.drive(0.8, 0.15)
    assert robot.is_driving()
    assert robot.error() < 3e-3


def test_a_reset_of_the_controller_makes_no_jump_and_odometry_less_sure(robot):
    robot.drive(1.0, 0.3)
    before = planar_pose(robot.odometry[-1].pose.pose, 'odom')
    robot.fault('reset')
    robot.until(lambda: robot.report.state.endswith('its encoders were reset'))
    seen = len(robot.odometry)
    robot.until(lambda: len(robot.odometry) > seen + 1)
    after = robot.odometry[-1]
    assert before.distance_to(planar_pose(after.pose.pose, 'odom')) < 0.05
    missed = planar_pose(after.pose.pose, 'odom').distance_to(robot.controller.T_world_base)
    assert missed < math.sqrt(after.pose.covariance[0])
    robot.drive(0.8, 0.3)
    assert robot.is_driving()


def test_a_controller_that_hung_runs_one_command_at_most_and_then_stops(robot):
    robot.drive(0.8, 0.3)
    robot.fault('hang', 1.0)
    robot.wait(0.5)
    assert not robot.report.is_connected
    robot.until(lambda: robot.report.is_connected)
    assert robot.is_stopped() or robot.controller._firmware.pwm == (0, 0)


def test_a_lower_speed_limit_holds_at_once_without_a_jerk(robot):
    robot.drive(1.0, 0.4)
    assert robot.node.set_parameters([Parameter('max_linear_velocity', value=0.1)])[0].successful
    assert robot.node._session.drive.velocity.forward > 0.3
    robot.drive(1.2, 0.4)
    assert robot.node._session.drive.velocity.forward == pytest.approx(0.1)
    refusal = robot.node.set_parameters([Parameter('wheel_radius', value=0.05)])[0]
    assert refusal.reason.startswith('wheel_radius can only be set at start')


def test_the_motors_stop_when_the_node_is_deactivated_and_an_emergency_stop_then_is_not_lost(robot):
    robot.drive(0.8, 0.3)
    robot.node.trigger_deactivate()
    assert robot.is_stopped() or robot.controller._firmware.pwm == (0, 0)
    seen = len(robot.odometry)
    robot.stop()
    robot.wait(0.3)
    assert len(robot.odometry) <= seen + 1  # one may have been on its way
    robot.node.trigger_activate()
    robot.until(lambda: len(robot.odometry) > seen + 2)
    robot.drive(0.4, 0.3)
    assert robot.is_stopped()
    robot.stop(is_on=False)
    robot.drive(0.8, 0.3)
    assert robot.is_driving()


def test_odometry_is_reset_on_request(robot):
    robot.drive(0.6, 0.3)
    robot.settle()
    answer = robot.call('reset_odometry')
    assert (answer.success, answer.message) == (True, 'odometry reset to the origin')
    seen = len(robot.odometry)
    robot.until(lambda: len(robot.odometry) > seen + 3)
    assert abs(robot.odometry[-1].pose.pose.position.x) < 1e-3


def test_unstamped_velocities_are_taken_when_set(graph, tmp_path):
    node = graph.add(MotorBridgeNode, port=str(tmp_path / 'none'), stamped=False)
    person = graph.add(lambda **options: Node('person', **options))
    publisher = person.create_publisher(Twist, 'cmd_vel', 10)
    assert graph.spin_until(lambda: publisher.get_subscription_count() == 1)
    twist = Twist()
    twist.linear.x = 0.2
    publisher.publish(twist)
    assert graph.spin_until(lambda: node._session.drive._target.forward == 0.2)


def test_velocities_of_the_other_type_are_reported(robot, monkeypatch):
    # Publishers of both types cannot share this process.
    offer = SimpleNamespace(topic_type='geometry_msgs/msg/Twist')
    find = {'/cmd_vel': [offer]}.get
    monkeypatch.setattr(robot.node, 'get_publishers_info_by_topic', lambda topic: find(topic, []))
    monkeypatch.setattr(input_watch, '_START_TIME', -1.0)
    robot.until(lambda: robot.report.is_connected)
    words = '/cmd_vel is published as geometry_msgs/msg/Twist, not as geometry_msgs/msg/TwistStamped; change stamped'
    assert words in robot.message().message


def test_what_cannot_be_obeyed_is_refused_in_one_line(robot):
    rejected = robot.node._guard.counts['cmd_vel'].rejected
    for count, (forward, ago, words) in enumerate(
        (
            (math.nan, 0.0, 'cmd_vel has a velocity that is not finite'),
            (-1.7e308, 0.0, 'cmd_vel has a velocity that is implausibly high'),
            (0.2, 5.0, 'cmd_vel is too old'),
            (0.2, -5.0, 'cmd_vel has a stamp in the future'),
        )
    ):
        now = robot.node.get_clock().now().nanoseconds - round(1e9 * ago)
        robot.send(forward, stamp=Time(sec=now // 10**9, nanosec=now % 10**9))
        robot.until(lambda count=count: rejected.total() > count)
        assert list(rejected)[count].startswith(words)
        assert '\n' not in list(rejected)[count]
    assert robot.is_stopped()
    # A bad velocity brakes at once, rather than after the timeout.
    robot.drive(0.6, 0.3)
    robot.send(math.nan)
    robot.until(lambda: robot.node._session.drive._target.forward == 0.0, 0.3)


def test_two_drivers_at_once_are_refused(robot):
    robot.drive(0.6, 0.3)
    other = robot.person.create_publisher(TwistStamped, 'cmd_vel', 10)
    robot.until(lambda: other.get_subscription_count() == 1)
    robot.drive(1.2, 0.3)
    assert robot.is_driving()  # a publisher that does not send does not count
    for _ in range(20):
        other.publish(TwistStamped())
        robot.drive(0.05, 0.3)
    robot.until(robot.is_stopped, 1.0)
    (refusal,) = robot.refusals()
    assert refusal.startswith('/person and /person send on cmd_vel at the same time, all are ignored')
    assert robot.node.status().message == refusal
    robot.drive(2.2, 0.3)
    assert robot.is_driving()


@pytest.mark.parametrize(
    ('parameters', 'words'),
    [
        ({'port': ''}, 'port is empty; set it to the serial port'),
        ({'base_frame': 'odom'}, 'odom_frame and base_frame are equal; give them different names'),
        ({'left_wheel_joint': 'right_wheel_joint'}, 'left_wheel_joint and right_wheel_joint are equal'),
        ({'wheel_separation': math.nan}, 'setting wheel_separation is nan m, allowed is'),
        ({'wheel_radius': 0.4, 'ticks_per_revolution': 4}, 'frame, below the resolution of 1'),
        ({'wheel_radios': 0.03}, 'parameter wheel_radios does not exist, did you mean wheel_radius'),
    ],
)
def test_bad_parameters_are_refused_in_one_line(graph, parameters, words):
    with pytest.raises((SettingsError, MotorBridgeError), match=words) as refusal:
        graph.add(MotorBridgeNode, **parameters)
    assert '\n' not in str(refusal.value)


def test_a_bad_start_is_one_line_and_exit_code_1(capfd):
    assert run_in_process(main, '--ros-args', '-p', 'wheel_radius:=-1.0') == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith('motor_bridge: setting wheel_radius is -1.0 m, allowed is 0.005 to 1 m')
