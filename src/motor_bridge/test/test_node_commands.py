"""Emergency stops that outlive the node, and commands of other types and topics."""

import math
import time

import pytest
from emulated_robot import Robot
from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from motor_bridge.core.motor_bridge_error import MotorBridgeError
from motor_bridge.node_output import estop_file, is_stop_kept, keep_stop
from shirube_ros.quality_of_service import map_profile

pytestmark = pytest.mark.newest_set_only


def restart(robot):
    """Configure the node again, which loads everything as after a restart of its process."""
    for transition in ('deactivate', 'cleanup', 'configure', 'activate'):
        getattr(robot.node, f'trigger_{transition}')()
    robot.until(lambda: robot.report.is_connected)
    robot.until(lambda: robot.velocities.get_subscription_count() == 1)


def is_stopped(robot):
    return robot.node._session.drive.is_stopped


def test_an_emergency_stop_outlives_a_restart_and_so_does_its_release(robot):
    storing = robot.person.create_publisher(Bool, 'estop', map_profile())
    storing.publish(Bool(data=False))  # stored before the stop, so it must not release it
    robot.stop()
    robot.until(lambda: is_stopped(robot))
    restart(robot)
    robot.drive(0.8, 0.3)
    assert robot.is_stopped()
    assert robot.node.status().message.startswith('stopped by estop before the restart; publish false')
    robot.until(lambda: storing.get_subscription_count() == 2)
    storing.publish(Bool(data=False))
    robot.until(lambda: not is_stopped(robot))
    restart(robot)
    robot.drive(0.8, 0.3)
    assert robot.is_driving()


def test_a_stored_stop_stops_and_is_released_by_any_publisher(robot):
    storing = robot.person.create_publisher(Bool, 'estop', map_profile())
    storing.publish(Bool(data=True))
    robot.until(lambda: storing.get_subscription_count() == 2)
    robot.wait(0.2)
    assert is_stopped(robot)
    robot.stop(is_on=False)
    robot.until(lambda: not is_stopped(robot))
    robot.drive(0.8, 0.3)
    assert robot.is_driving()
    robot.person.destroy_publisher(storing)
    robot.until(lambda: robot.node._stored_estop is None)


def test_without_a_heartbeat_the_robot_stops(graph, tmp_path):
    with Robot(graph, tmp_path / 'tty', estop_heartbeat=0.4) as robot:
        robot.until(lambda: robot.report.is_connected)
        robot.drive(0.5, 0.3)
        assert robot.is_stopped()  # none has come yet
        for _ in range(2):
            for _ in range(6):
                robot.stop(is_on=False)
                robot.drive(0.1, 0.3)
            # A machine that stalls for longer than the heartbeat stops the robot, as it should.
            assert robot.is_driving(patience=5.0, keep=lambda: robot.stop(is_on=False))
            robot.drive(0.8, 0.3)
            assert robot.is_stopped()
            assert 'no message on estop for 0.4 s (estop_heartbeat)' in robot.node.status().message


def test_on_a_read_only_disk_the_stop_holds_while_the_node_runs_and_a_line_warns(graph, tmp_path, capfd):
    (tmp_path / 'file').touch()
    with Robot(graph, tmp_path / 'tty', state_dir=str(tmp_path / 'file')) as robot:
        for _ in range(3):
            robot.stop()
            robot.wait(0.1)
            assert is_stopped(robot)
    (warning,) = [line for line in capfd.readouterr().err.splitlines() if 'not kept over a restart' in line]
    assert 'set state_dir to a writable folder' in warning


def test_each_node_has_its_file_and_an_unknown_state_is_a_stop(tmp_path, monkeypatch):
    def fail(*_, **__):
        raise PermissionError(1, 'not permitted')

    monkeypatch.setenv('ROS_HOME', str(tmp_path))
    one, other = (estop_file('', f'/{name}/motor_bridge') for name in ('robot1', 'robot2'))
    assert one == tmp_path / 'shirube' / 'robot1.motor_bridge.estop'
    keep_stop(one, is_on=True)
    assert (is_stop_kept(one), is_stop_kept(other)) == (True, False)
    for _ in range(2):
        keep_stop(one, is_on=False)
        assert not is_stop_kept(one)
    monkeypatch.setattr(type(one), 'lstat', fail)
    assert is_stop_kept(one)
    monkeypatch.setattr(type(one), 'unlink', fail)
    with pytest.raises(MotorBridgeError, match=r'estop is released, but only until a restart: .*: not perm'):
        keep_stop(one, is_on=False)


def test_the_velocities_of_both_wheels_drive(graph, tmp_path):
    with Robot(graph, tmp_path / 'tty', command_type='joints') as robot:
        speeds = robot.person.create_publisher(JointState, 'joint_commands', 10)
        robot.until(lambda: speeds.get_subscription_count() == 1)
        names = ['right_wheel_joint', 'left_wheel_joint', 'arm']
        for _ in range(20):
            speeds.publish(JointState(name=names, velocity=[8.0, 6.0, 1.0]))
            robot.wait(0.05)
        target = robot.node._session.drive._target
        assert (target.forward, target.turn_rate) == pytest.approx((0.033 * 7.0, 0.033 * 2.0 / 0.2))
        assert robot.controller.wheel_speeds == pytest.approx((0.91 * 6.0, 0.91 * 8.0), rel=0.1)
        for velocities in ([8.0, math.nan, 1.0], [8.0, 6.0], []):
            speeds.publish(JointState(name=names, velocity=velocities))
        robot.until(lambda: len(robot.refusals('joint_commands')) == 2)
        assert robot.refusals('joint_commands') == [
            'joint_commands has a velocity that is not finite; check its publisher',
            'joint_commands has no velocity of left_wheel_joint and right_wheel_joint; check its publisher',
        ]


def test_the_topic_with_the_highest_priority_drives_until_it_times_out(graph, tmp_path):
    with Robot(graph, tmp_path / 'tty', mux_topics='joy_vel, cmd_vel') as robot:
        joystick = robot.person.create_publisher(TwistStamped, 'joy_vel', 10)
        robot.until(lambda: joystick.get_subscription_count() == 1)
        robot.drive(0.3, 0.3)
        drive = robot.node._session.drive
        assert drive._target.forward == 0.3
        joystick.publish(TwistStamped())
        sent = time.monotonic()
        robot.until(lambda: drive._target.forward == 0.0)
        while time.monotonic() < sent + 0.3:
            robot.drive(0.02, 0.3)
        assert drive._target.forward == 0.0
        robot.drive(0.5, 0.3)
        assert drive._target.forward == 0.3
