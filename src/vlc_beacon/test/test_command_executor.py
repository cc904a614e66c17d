import math

import numpy as np
import pytest
from driven_robot import STEP, DrivenRobot

from shirube_core.geometry import SE2, wrap_angle
from vlc_beacon.core.command_executor import CommandExecutor, DriveSettings
from vlc_beacon.core.packet.command_packet import Operation

SETTINGS = DriveSettings()
LIMIT = 0.5


def robot(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, **noise: float) -> DrivenRobot:
    return DrivenRobot(CommandExecutor(SETTINGS, LIMIT), SE2(x, y, yaw), **noise)


def speed_of(driven: DrivenRobot) -> float:
    return driven.track[-2].distance_to(driven.track[-1]) / STEP


def test_the_papers_run():
    """Straight, at A slow down and turn right, at B turn right and speed up (fig. 4)."""
    driven = robot()
    driven.drive(5.0)
    at_a = driven.pose
    driven.executor.execute(Operation.SLOW, 0.1)
    driven.executor.execute(Operation.TURN, -math.pi / 2.0)
    driven.drive(10.0)
    assert speed_of(driven) == pytest.approx(0.097, rel=0.02)
    assert driven.pose.yaw == pytest.approx(-math.pi / 2.0, abs=0.03)
    assert driven.pose.x - at_a.x < 0.3**2 / (2.0 * SETTINGS.acceleration) + 0.3 * 5 * STEP + 0.03
    driven.executor.execute(Operation.TURN, -math.pi / 2.0)
    driven.executor.execute(Operation.SPEED_UP, 0.4)
    driven.drive(10.0)
    assert speed_of(driven) == pytest.approx(0.388, rel=0.02)
    assert abs(wrap_angle(driven.pose.yaw - math.pi)) < 0.03


def assert_on_line_of(pose: SE2, start: SE2) -> None:
    assert abs((start.inverse() @ pose).y) < 0.01
    assert pose.yaw == pytest.approx(start.yaw, abs=0.02)


def test_it_keeps_to_its_line_though_somebody_pushes_it_aside():
    driven = robot(1.0, 2.0, 0.7, noise=0.0)
    driven.drive(2.0)
    driven.pose = SE2(driven.pose.x - 0.1, driven.pose.y + 0.1, driven.pose.yaw)
    driven.drive(15.0)
    assert_on_line_of(driven.pose, SE2(1.0, 2.0, 0.7))


@pytest.mark.parametrize('angle', [0.02, 1.0, -2.0, math.pi, -4.5, 2.0 * math.pi])
def test_it_turns_in_the_commanded_direction_and_angle_on_the_spot(angle):
    driven = robot(noise=0.0)
    driven.drive(3.0)
    driven.executor.execute(Operation.TURN, angle)
    driven.drive(12.0)
    assert driven.pose.yaw == pytest.approx(angle, abs=0.03)
    yaws = np.array([pose.yaw for pose in driven.track])
    assert np.all(np.sign(angle) * yaws < abs(angle) + 0.03)
    turning = [v for v in driven.velocities if abs(v.turn_rate) > 0.2]
    assert len(turning) > 50 or abs(angle) < 1.0
    assert all(v.forward == 0.0 for v in turning)


def test_stop_holds_until_resume():
    driven = robot()
    driven.drive(2.0)
    for operation, value, speed in (
        (Operation.STOP, 0.0, 0.0),
        (Operation.SPEED_UP, 0.5, 0.0),
        (Operation.RESUME, 0.0, SETTINGS.cruise_speed),
    ):
        driven.executor.execute(operation, value)
        driven.drive(3.0)
        assert driven.velocities[-1].forward == speed
        assert driven.velocities[-1].is_zero == (speed == 0.0)


def test_without_poses_it_brakes_and_leaves_the_wheels_to_others():
    driven = robot()
    driven.drive(3.0)
    before = driven.pose
    driven.drive(4.0, sees=False)
    assert driven.velocities[-1] is None
    first = driven.velocities.index(None, 181)
    assert driven.velocities[first - 1].is_zero
    assert not driven.velocities[first - 2].is_zero
    braking = 0.3**2 / (2.0 * SETTINGS.acceleration)
    assert driven.pose.distance_to(before) < 0.3 * (SETTINGS.pose_timeout + 6 * STEP) + braking
    driven.drive(2.0)
    assert driven.velocities[-1].forward == SETTINGS.cruise_speed


def test_before_the_first_pose_there_is_no_velocity():
    executor = CommandExecutor(SETTINGS, LIMIT)
    executor.execute(Operation.TURN, 1.0)
    assert executor.velocity(0.0) is None


def test_no_commands_exceed_the_limits():
    rng = np.random.default_rng(4)
    driven = robot(noise=0.01)
    for _ in range(150):
        operation = Operation(int(rng.integers(1, 6)))
        value = rng.uniform(0.0, 5.0) if operation != Operation.TURN else rng.normal(0.0, 3.0)
        driven.executor.execute(operation, float(value))
        driven.drive(float(rng.uniform(0.05, 1.0)), sees=bool(rng.random() < 0.9))
    given = np.array([(v.forward, v.turn_rate) if v else (0.0, 0.0) for v in driven.velocities])
    assert given[:, 0].min() >= 0.0
    assert (np.abs(given).max(axis=0) <= (LIMIT, SETTINGS.turn_rate_max)).all()
    steps = np.abs(np.diff(given, axis=0, prepend=0.0)).max(axis=0)
    assert (steps <= np.array([SETTINGS.acceleration, SETTINGS.turn_acceleration]) * STEP + 1e-9).all()


def test_a_cruise_speed_above_the_limit_is_cut():
    driven = DrivenRobot(CommandExecutor(DriveSettings(cruise_speed=2.0), 0.2), SE2(0.0, 0.0, 0.0))
    driven.drive(6.0)
    assert driven.velocities[-1].forward == 0.2


@pytest.mark.parametrize('is_turning', [False, True])
def test_where_others_left_it_a_new_line_begins(is_turning):
    driven = robot(noise=0.0)
    driven.drive(2.0)
    if is_turning:
        driven.executor.execute(Operation.TURN, 2.0)
    driven.drive(2.0, sees=False)
    assert driven.velocities[-1] is None
    driven.pose = SE2(1.0, 3.0, -0.8)
    driven.drive(6.0)
    assert_on_line_of(driven.pose, SE2(1.0, 3.0, -0.8))
