"""The node drives and publishes odometry, in wall time and in simulated time."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from emulated_robot import Robot
from rosgraph_msgs.msg import Clock

from shirube_ros.message_conversion import planar_pose, planar_pose_with_covariance


def test_velocities_drive_and_odometry_follows(robot):
    robot.drive(2.0, 0.3, 0.6)
    assert robot.controller.T_world_base.x > 0.2
    assert robot.controller.T_world_base.yaw > 0.5
    # Over a second: on a busy machine the controller may stop between two reads.
    driven = [message.twist.twist for message in robot.odometry[-30:]]
    assert np.median([twist.linear.x for twist in driven]) == pytest.approx(0.91 * 0.3, rel=0.15)
    assert np.median([twist.angular.z for twist in driven]) == pytest.approx(0.91 * 0.6, rel=0.3)
    robot.until(robot.is_stopped, 0.5 + 0.3 / 0.5 + 1.0)  # without commands
    assert robot.error() < 2e-3
    last = robot.odometry[-1]
    assert (last.header.frame_id, last.child_frame_id) == ('odom', 'base_link')
    _, covariance = planar_pose_with_covariance(last.pose, 'odom')
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    joints = robot.joints[-1]
    assert list(joints.name) == ['left_wheel_joint', 'right_wheel_joint']
    assert joints.position == pytest.approx(robot.controller._body.wheel_angles, abs=0.02)
    assert robot.message().message == 'stopped, cmd_vel timed out'


@pytest.mark.parametrize(
    ('firmware', 'latency', 'jitter'),
    [('ros_arduino_bridge', 0.06, 0.06), ('motor_controller', 0.06, 0.06), ('motor_controller', 0.25, 0.0)],
)
def test_it_connects_and_drives_over_lines_with_latency(graph, tmp_path, firmware, latency, jitter):
    faults = {'latency': latency, 'jitter': jitter}
    with Robot(graph, tmp_path / 'tty', firmware=firmware, faults=faults) as robot:
        robot.until(lambda: robot.report.is_connected, 5.0)
        assert ('with checksums' in robot.report.state) == (firmware == 'motor_controller')
        robot.drive(1.2, 0.3)
        assert robot.is_driving()
        assert robot.report.faults.total() == 0


def test_with_simulated_time_everything_is_in_lock_step(graph, tmp_path, capfd):
    with Robot(graph, tmp_path / 'tty', real_time=False, use_sim_time=True) as robot:
        clock = robot.person.create_publisher(Clock, '/clock', 10)
        robot.until(lambda: clock.get_subscription_count() >= 1)
        robot.until(lambda: robot.report.is_connected)
        stamps = []
        for step in range(1, 61):
            with robot.lock:
                robot.controller.advance(step / 30.0)
            sec, nanosec = divmod(round(1e9 * step / 30.0), 10**9)
            seen = len(robot.odometry)
            robot.send(0.2)
            clock.publish(Clock(clock=Time(sec=sec, nanosec=nanosec)))
            robot.until(lambda seen=seen, step=step: len(robot.odometry) > seen or step == 1, 1.0)
            stamps += [o.header.stamp.sec + 1e-9 * o.header.stamp.nanosec for o in robot.odometry[seen:]]
        assert stamps[-1] == pytest.approx(2.0, abs=1e-6)
        assert robot.controller.T_world_base.x > 0.1
        pose = planar_pose(robot.odometry[-1].pose.pose, 'odom')
        assert pose.distance_to(robot.controller.T_world_base) < 2e-3
        robot.wait(0.6)
        assert robot.is_driving()  # simulated time is paused: nothing has timed out
        for nanosec in (0, 100_000_000, 200_000_000):
            clock.publish(Clock(clock=Time(sec=1, nanosec=nanosec)))
            robot.wait(0.1)
        robot.until(lambda: robot.report.faults['clock jumped back'] == 1, 3.0)
        assert capfd.readouterr().err.count('clock jumped back: the robot stops') == 1
