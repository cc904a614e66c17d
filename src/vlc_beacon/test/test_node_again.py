"""Resets of the node: clock jumps back, and a pose found after it was lost."""

from __future__ import annotations

from pathlib import Path

import pytest
from beacon_robot import LEANING, Robot, header, odometry
from geometry_msgs.msg import QuaternionStamped
from receptions import POSE, with_fix, without_fix
from sensor_msgs.msg import Imu

from shirube_ros.isolated_graph import IsolatedGraph
from vlc_beacon.core.packet.command_packet import Operation


def test_odometry_and_tilt_after_a_jump_back_go_to_the_new_receiver(
    graph: IsolatedGraph, beacons_file: Path
) -> None:
    robot = Robot(graph, beacons_file)
    robot.send('odom', odometry(100.0))
    robot.send('odom', odometry(50.0))
    robot.send('imu', Imu(header=header(60.0, 'base_link'), orientation=LEANING))
    robot.send('imu', Imu(header=header(20.0, 'base_link'), orientation=LEANING))
    robot.send('attitude', QuaternionStamped(header=header(30.0, 'base_link'), quaternion=LEANING))
    robot.send('attitude', QuaternionStamped(header=header(5.0, 'base_link'), quaternion=LEANING))
    assert [[call[:2] for call in receiver.calls] for receiver in robot.receivers] == [
        [('odometry', 100.0)],
        [('odometry', 50.0), ('tilt', 60.0)],
        [('tilt', 20.0), ('tilt', 30.0)],
        [('tilt', 5.0)],
    ]


def test_after_a_jump_back_the_line_begins_where_the_robot_is_then(
    graph: IsolatedGraph, beacons_file: Path
) -> None:
    robot = Robot(graph, beacons_file, drive=True)
    before = robot.node._command_executor
    robot.send_image(100.0)
    before.execute(Operation.TURN, 1.0)
    robot.send_image(5.0)
    after = robot.node._command_executor
    assert after is not before
    after.update_pose(5.1, POSE)
    assert max(after.velocity(5.1 + 0.1 * k).forward for k in range(3)) > 0.0


def test_a_stop_outlives_a_jump_back(graph: IsolatedGraph, beacons_file: Path) -> None:
    robot = Robot(graph, beacons_file, drive=True)
    robot.send_image(100.0)
    robot.node._command_executor.execute(Operation.STOP, 0.0)
    robot.send_image(5.0)
    executor = robot.node._command_executor
    executor.update_pose(5.1, POSE)
    assert all(executor.velocity(5.1 + 0.1 * k).is_zero for k in range(3))


def test_a_lost_pose_is_logged_after_the_throttle_interval(
    graph: IsolatedGraph, beacons_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot(graph, beacons_file)
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
