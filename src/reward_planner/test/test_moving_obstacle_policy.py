"""The robot waits for people who cross, goes around those who approach or stay, and drives into nobody."""

import math

import numpy as np
import pytest
from grid_drive import RADIUS, TICK, GridDrive, goal_at, hall

from reward_planner.core.driving.drive_state import DriveState
from reward_planner.core.driving.moving_obstacle_policy import MovingObstacle, MovingObstaclePolicy
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2

BODY = 0.25  # radius of a person [m]


class Encounter(GridDrive):
    """A drive with a person whose track is exact, at 10 Hz."""

    def __init__(self, walls, position, velocity, ends=math.inf):
        super().__init__(walls, SE2(1.0, 3.0, 0.0))
        self.person = MovingObstacle(0.0, position, velocity, BODY)
        self.ends, self.is_touched = ends, False
        self.contact_speeds, self.states = [], set()

    def tick(self):
        now = self.robot.time
        is_there = now < self.ends
        if len(self.drives) % 2 == 0:
            place = self.person.position_at(now)
            track = MovingObstacle(now, place, self.person.velocity, BODY)
            self.controller.moving_obstacles = (track,) if is_there else ()
        before = self.pose
        super().tick()
        here = self.person.position_at(self.robot.time)
        is_touched = is_there and math.dist(here, (self.pose.x, self.pose.y)) < RADIUS + BODY
        if is_touched and not self.is_touched:
            self.contact_speeds.append(before.distance_to(self.pose) / TICK)
        self.is_touched = is_touched
        self.states.add(self.drives[-1].state)


@pytest.mark.parametrize(('speed', 'ahead'), [(0.4, 3.0), (1.0, 2.0), (1.0, 3.0), (1.5, 2.0), (1.5, 4.5)])
def test_a_person_who_crosses_is_not_driven_into(speed, ahead):
    drive = Encounter(hall(), (1.0 + ahead, 3.0 - speed * ahead / 0.5), (0.0, speed))
    drive.controller.set_goal(goal_at(9.0, 3.0))
    assert drive.run(60.0).state is DriveState.GOAL_REACHED
    assert max(drive.contact_speeds, default=0.0) < 0.02
    assert drive.states & {DriveState.GIVING_WAY, DriveState.WAITING, DriveState.GOING_AROUND}


@pytest.mark.parametrize('speed', [0.3, 1.0, 1.4])
def test_a_person_who_approaches_is_gone_around_or_meets_a_robot_that_is_stopped(speed):
    drive = Encounter(hall(), (8.0, 3.05), (-speed, 0.0))
    drive.controller.set_goal(goal_at(9.0, 3.0))
    assert drive.run(90.0).state is DriveState.GOAL_REACHED
    assert max(drive.contact_speeds, default=0.0) < 0.02
    assert DriveState.GOING_AROUND in drive.states


def test_waiting_for_a_person_who_stays_is_bounded():
    drive = Encounter(hall(), (4.0, 3.0), (0.0, 0.0))
    drive.controller.set_goal(goal_at(9.0, 3.0))
    assert drive.run(60.0).state is DriveState.GOAL_REACHED
    assert drive.contact_speeds == []
    assert {DriveState.WAITING, DriveState.GOING_AROUND} <= drive.states
    details = {each.detail for each in drive.drives if each.state is DriveState.WAITING}
    assert 'waiting for a moving obstacle at x 4.0 m, y 3.0 m, with 0.0 m/s' in details


def test_a_person_who_blocks_a_corridor_is_waited_for_and_the_goal_is_reached_when_he_leaves():
    walls = hall()
    walls[:24, 30:60] = walls[36:, 30:60] = True  # a corridor of 1.2 m
    drive = Encounter(walls, (4.5, 3.0), (0.0, 0.0), ends=70.0)
    drive.controller.set_goal(goal_at(9.0, 3.0))
    last = drive.run(69.0, until=(DriveState.UNREACHABLE,))
    assert last.state is DriveState.UNREACHABLE
    assert 'obstacles block every path; tried wait, look_around' in last.detail
    assert DriveState.RECOVERING in drive.states
    assert drive.run(60.0).state is DriveState.GOAL_REACHED
    assert drive.contact_speeds == []


@pytest.mark.parametrize(('velocity', 'ends'), [((-0.3, 0.0), 9.0), ((0.0, 0.0), math.inf)])
def test_where_the_way_around_is_long_the_robot_waits_and_takes_it_if_the_person_stays(velocity, ends):
    walls = hall()
    # A corridor of 1.2 m; the way around is in the north.
    walls[:24, 30:60] = walls[36:52, 30:60] = walls[:24, 70:] = True
    drive = Encounter(walls, (4.5, 3.0), velocity, ends)
    drive.controller.set_goal(goal_at(6.5, 3.0))
    drive.run(60.0, until=(DriveState.WAITING,))
    waited = len(drive.drives)
    assert drive.run(60.0).state is DriveState.GOAL_REACHED
    assert any('the way around it is long' in each.detail for each in drive.drives[waited - 1 :])
    assert (max(pose.y for pose in drive.poses) > 3.7) == (ends == math.inf)
    assert max(drive.contact_speeds, default=0.0) < 0.02


@pytest.mark.parametrize(('pause', 'waits'), [(5.0, False), (60.0, True)])
def test_the_wait_at_one_place_is_bounded_until_long_after(pause, waits):
    policy, robot = MovingObstaclePolicy(), (SE2(0.0, 0.0, 0.0), 0.0, 0.3)
    ways = [np.linspace((0.1, 0.0), (length, 0.0), 50) for length in (4.0, 12.0, 12.0)]
    for start, expected in ((0.0, True), (20.0, False), (20.0 + pause, waits)):
        policy.reset()
        for k, way in enumerate(ways):
            now = start + 0.1 * k
            policy.react(way, robot, [MovingObstacle(now, (2.0, 0.0), (-0.5, 0.0), BODY)], now, DrivingSettings())
        assert policy.is_detour_long == expected


def test_a_person_beside_the_route_or_who_leaves_changes_nothing():
    for position, velocity in (((4.0, 4.2), (0.0, 0.0)), ((2.0, 3.0), (1.0, 0.0))):
        drive = Encounter(hall(), position, velocity)
        drive.controller.set_goal(goal_at(6.0, 3.0))
        assert drive.run(60.0).state is DriveState.GOAL_REACHED
        assert drive.states == {DriveState.DRIVING, DriveState.GOAL_REACHED}
