"""Straight legs, round corners, even acceleration: kinematics from the textbook."""

import math

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.robot.leg_drive import LegDrive, arc_motion
from shirube_core.geometry import SE2


@pytest.mark.parametrize('turn', [0.0, 1e-9, 0.7, -2.5])
@pytest.mark.parametrize('way', [1.3, -0.4, 0.0])
def test_an_arc_is_many_small_steps(way: float, turn: float) -> None:
    steps = 2000
    pose = SE2(0.0, 0.0, 0.0)
    for _ in range(steps):
        half = SE2(0.0, 0.0, 0.5 * turn / steps)
        pose = pose @ half @ SE2(way / steps, 0.0, 0.0) @ half
    found = arc_motion(way, turn)
    assert found.distance_to(pose) < 1e-6
    assert found.yaw_to(pose) == pytest.approx(0.0, abs=1e-9)


CORNERS = [(0.0, 0.0), (3.0, 0.0), (3.0, -2.0), (1.0, -2.0)]
SPEEDS = [0.5, 0.2, 0.6]
DRIVE = LegDrive(CORNERS, SPEEDS, radius=0.3, rest=1.5)


def motion(drive: LegDrive, step: float = 1e-3) -> tuple[np.ndarray, np.ndarray]:
    """Return times and x, y, yaw along a drive."""
    times = np.arange(0.0, drive.duration + 2.0 * step, step)
    poses = [drive.pose_at(float(time)) for time in times]
    return times, np.array([(pose.x, pose.y, pose.yaw) for pose in poses])


def test_it_begins_and_ends_at_rest_where_it_should() -> None:
    start, end = DRIVE.pose_at(1.5), DRIVE.pose_at(DRIVE.duration + 9.0)
    assert (start.x, start.y, start.yaw) == pytest.approx((0.0, 0.0, 0.0))
    assert (end.x, end.y, abs(end.yaw)) == pytest.approx((1.0, -2.0, math.pi))
    assert DRIVE.pose_at(-3.0) == DRIVE.pose_at(0.0) == start
    assert DRIVE.pose_at(1.6).x > 0.0


def test_legs_are_straight_and_corners_are_arcs() -> None:
    x, y, yaw = motion(DRIVE)[1].T
    first = (x < 2.7) & (y > -0.5)
    np.testing.assert_allclose(y[first], 0.0, atol=1e-12)
    np.testing.assert_allclose(yaw[first], 0.0, atol=1e-12)
    second = (y < -0.3) & (y > -1.7)
    np.testing.assert_allclose(x[second], 3.0, atol=1e-12)
    np.testing.assert_allclose(yaw[second], -0.5 * math.pi, atol=1e-12)
    corner = (x > 2.7) & (y > -0.3)
    np.testing.assert_allclose(np.hypot(x[corner] - 2.7, y[corner] + 0.3), 0.3, atol=1e-12)


def test_the_robot_looks_where_it_goes_at_the_speeds_of_the_legs() -> None:
    times, poses = motion(DRIVE)
    steps = np.diff(poses[:, :2], axis=0)
    speeds = np.hypot(*steps.T) / np.diff(times)
    going = speeds > 1e-3
    ahead = np.arctan2(steps[going, 1], steps[going, 0])
    turns = np.abs([math.remainder(a - b, math.tau) for a, b in zip(ahead, poses[:-1][going, 2])])
    assert turns.max() < 1e-3
    x, y = poses[:-1, 0], poses[:-1, 1]
    assert speeds[np.argmin(np.abs(x - 1.5) + np.abs(y))] == pytest.approx(0.5, abs=1e-6)
    assert speeds[(y < -0.1) & (y > -1.9)] == pytest.approx(0.2, abs=1e-6)
    assert speeds.max() == pytest.approx(0.6, abs=1e-6)
    assert np.abs(np.diff(speeds) / 1e-3).max() < 0.4 + 1e-6


def test_a_single_leg_takes_the_time_of_its_trapezoid() -> None:
    drive = LegDrive([(0.0, 0.0), (0.0, 4.0)], [0.5], radius=1.0, acceleration=0.25)
    assert drive.duration == pytest.approx(4.0 / 0.5 + 0.5 / 0.25)
    assert drive.pose_at(0.5 * drive.duration).y == pytest.approx(2.0)


def test_left_turns_are_mirrored_right_turns() -> None:
    left = LegDrive([(x, -y) for x, y in CORNERS], SPEEDS, radius=0.3, rest=1.5)
    (x, y, yaw), (other_x, other_y, other_yaw) = (motion(drive, 0.1)[1].T for drive in (DRIVE, left))
    np.testing.assert_allclose((x, y, np.cos(yaw)), (other_x, -other_y, np.cos(other_yaw)), atol=1e-9)


@pytest.mark.parametrize(
    'bad',
    [
        *({'speeds': [0.5, *middle, 0.5]} for middle in ((), (0.0,), (math.nan,), (3.0,))),
        *({'radius': 0.0}, {'radius': 1.1}, {'rest': -1.0}, {'corners': CORNERS[:1], 'speeds': []}),
        {'corners': [(0.0, 0.0), (math.inf, 0.0)], 'speeds': [0.5]},
        {'corners': [(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)], 'speeds': [0.5, 0.5]},
    ],
)
def test_drives_that_cannot_be_are_refused(bad: dict[str, object]) -> None:
    with pytest.raises(SceneError):
        LegDrive(**({'corners': CORNERS, 'speeds': SPEEDS, 'radius': 0.3, 'rest': 0.0} | bad))
