"""Without a route: each recovery behavior once, in its order, bounded, and backwards on free cells only."""

import math
from itertools import groupby

import numpy as np
import pytest
from grid_drive import RADIUS, GridDrive, goal_at, hall, is_stopped

from reward_planner.core.driving.drive_state import DriveState
from reward_planner.core.driving.moving_obstacle_policy import MovingObstacle
from reward_planner.core.driving.path_following import CELL_MARGIN
from reward_planner.core.driving.recovery import free_distance_behind, parse_recovery
from reward_planner.core.driving.stuck_check import StuckCheck
from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN, GridFrame
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2


def passage():
    """The hall with a passage of 1.2 m through a wall."""
    walls = hall()
    walls[:24, 50:54] = walls[36:, 50:54] = True
    return walls


def blocked_drive(settings=None, seconds=5.0):
    """A robot on its way to the passage, which is blocked after some time."""
    drive = GridDrive(passage(), SE2(1.0, 3.0, 0.0), settings)
    drive.controller.set_goal(goal_at(9.0, 3.0))
    drive.run(seconds)
    drive.walls[24:36, 50:54] = True
    return drive


def behaviors(drive):
    """The recovery behaviors of a drive in their order."""
    details = [each.detail.split(' (')[0] for each in drive.drives if each.state is DriveState.RECOVERING]
    return [name.removeprefix('recovering: ') for name, _ in groupby(details)]


def test_every_behavior_runs_once_in_its_order_before_the_robot_gives_up_with_the_reason():
    drive = blocked_drive(DrivingSettings(recovery='replan, wait look_around back_up', recovery_wait=2.0))
    last = drive.run(60.0, until=(DriveState.UNREACHABLE,))
    assert behaviors(drive) == ['stopping', 'replan', 'wait', 'look around', 'back up']
    assert last.detail == ('no path to the goal: obstacles block every path; tried replan, wait, look_around, back_up')
    steps = zip(drive.poses, drive.poses[1:], drive.drives, strict=False)
    turned = sum(a.yaw_to(b) for a, b, done in steps if 'look around' in done.detail)
    assert turned == pytest.approx(math.tau, abs=0.3)
    assert -sum(min(each.velocity.forward, 0.0) for each in drive.drives) * 0.05 == pytest.approx(0.3, abs=0.06)
    assert is_stopped(drive.run(20.0, until=()))
    assert len(behaviors(drive)) == 5  # not again


@pytest.mark.parametrize('opens_after', [3.0, 10.0, 40.0])
def test_a_passage_that_opens_again_is_driven_through(opens_after):
    drive = blocked_drive()
    drive.run(opens_after)
    drive.walls = passage()
    assert drive.run(60.0).state is DriveState.GOAL_REACHED


def test_all_behaviors_are_allowed_again_at_another_place_and_for_another_goal():
    drive = blocked_drive(DrivingSettings(recovery='wait', recovery_wait=1.0))
    drive.run(20.0, until=(DriveState.UNREACHABLE,))
    drive.controller.set_goal(goal_at(9.0, 4.0))
    drive.run(20.0, until=(DriveState.UNREACHABLE,))
    drive.walls = passage()
    drive.run(60.0, until=(DriveState.DRIVING,))
    place = drive.pose
    while drive.pose.distance_to(place) < 0.6:
        drive.tick()
    drive.walls[24:36, 50:54] = True
    drive.run(20.0, until=(DriveState.UNREACHABLE,))
    assert behaviors(drive).count('wait') == 3


@pytest.mark.parametrize(('seconds', 'limit'), [(5.0, 20.0), (8.0, 5.0)])
def test_without_recovery_the_robot_gives_up_as_soon_as_it_has_seen_the_closed_passage(seconds, limit):
    drive = blocked_drive(DrivingSettings(recovery=''), seconds)
    assert drive.run(limit, until=(DriveState.UNREACHABLE,)).detail.endswith('block every path')
    assert behaviors(drive) == ['stopping']


def test_a_name_that_is_no_behavior_is_refused_with_all_that_are():
    with pytest.raises(DrivingError, match="'wait, dance'; give names of look_around, wait, back_up, clear"):
        parse_recovery('wait, dance')


@pytest.mark.parametrize('yaw', np.linspace(-3.0, 3.0, 7))
def test_the_free_distance_behind_is_that_of_a_disc_moved_in_small_steps(yaw):
    rng, frame = np.random.default_rng(3), GridFrame(-2.0, -2.0, 0.05, 80, 80)
    for _ in range(10):
        cells = np.full(frame.shape, FREE, dtype=np.int8)
        cells[tuple(rng.integers(0, 80, (2, 12)))] = rng.choice([OCCUPIED, UNKNOWN], 12)
        known = GlobalMap(0.05, 1_000_000)
        known.write(LocalMap(frame, cells, np.ones(frame.shape, dtype=bool)))
        robot = SE2(*rng.uniform(-0.3, 0.3, 2), yaw)
        x, y = frame.centre_of(np.argwhere(cells != FREE)).T
        is_other = (cells[cells != FREE] == OCCUPIED) | (np.hypot(x - robot.x, y - robot.y) > RADIUS)
        reach = RADIUS + CELL_MARGIN * 0.05
        ahead, steps = np.array([math.cos(yaw), math.sin(yaw)]), np.arange(0.0, 0.8, 1e-3)[:, None]
        is_behind = (x - robot.x) * ahead[0] + (y - robot.y) * ahead[1] < 0.0
        gaps = np.hypot(x - robot.x + steps * ahead[0], y - robot.y + steps * ahead[1])
        meets = (is_behind & is_other & (gaps < reach)).any(axis=1)
        expected = steps[meets.argmax(), 0] if meets.any() else 0.8
        assert max(free_distance_behind(known, robot, RADIUS, 0.8), 0.0) == pytest.approx(expected, abs=2e-3)


def test_a_robot_with_a_wall_behind_does_not_back_up():
    drive = GridDrive(passage(), SE2(0.35, 3.0, 0.0), DrivingSettings(recovery='back_up'))
    drive.walls[24:36, 50:54] = True
    drive.controller.set_goal(goal_at(9.0, 3.0))
    drive.sense()
    drive.global_map.write(LocalMap(drive.frame, (100 * drive.walls).astype(np.int8), np.ones_like(drive.walls)))
    last = drive.run(20.0, until=(DriveState.UNREACHABLE,))
    assert last.detail.endswith('; tried back_up (not possible)')
    assert drive.way() < 1e-6


@pytest.mark.parametrize('distance', [1.0, 3.0])
def test_a_robot_that_stays_near_somebody_is_not_held_by_furniture_but_keeps_its_route_for_7_of_10_s(distance):
    check, robot = StuckCheck(), SE2(0.0, 0.0, 0.0)
    for now in np.arange(0.01, 35.0, 0.05):
        check.note_people(now, robot, [MovingObstacle(now, (distance, 0.0), (0.0, 0.0), 0.2)])
        check.update(now, robot, is_driving=True)
        assert check.is_oscillating == (distance < 2.0 and now > 10.01 and (now - 0.01) % 10.0 < 7.0)
        assert check.is_held == (distance > 2.0 and now > 1.02)
    check.note_people(35.0, SE2(0.6, 0.0, 0.0), [])
    assert not check.is_oscillating
    check.note_people(95.0, SE2(0.6, 0.0, 0.0), [MovingObstacle(95.0, (1.0, 0.0), (0.0, 0.0), 0.2)])
    assert not check.is_oscillating  # a lamp stopped it in between
