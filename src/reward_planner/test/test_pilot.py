"""The closed loop: a robot that senses, maps, plans and drives gets to its goal and hits nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from grid_drive import RADIUS, TICK, GridDrive, coarse, goal_at, roomy_place

from reward_planner.core.driving.drive import DriveState
from reward_planner.core.driving.driving_error import DrivingError
from reward_planner.core.driving.driving_settings import DrivingSettings
from reward_planner.core.driving.light_command import LightCommand
from reward_planner.core.driving.velocity_ramp import Velocity
from reward_planner.core.grid.footprint import clearance
from reward_planner.core.mapping.local_map import LocalMap
from reward_planner.core.route.shortest_route import shortest_route
from scene_simulator.grid_maps import maze, random_field, rooms, warehouse
from shirube_geometry import PlanarPose


def hall(rows=60, columns=100):
    """A closed hall of 6 x 10 m."""
    walls = np.zeros((rows, columns), dtype=bool)
    walls[[0, -1]] = walls[:, [0, -1]] = True
    return walls


def wall_with_door():
    """The hall with a wall across, and a door at its upper end."""
    walls = hall()
    walls[:45, 50:52] = True
    return walls


def is_standing(drive):
    velocity = drive.velocity
    return velocity is None or max(abs(velocity.forward), abs(velocity.turn_rate)) < 1e-3


WORLDS = {
    'rooms': coarse(rooms(24, 2, room=8, door=3, closed=0.0)),
    'maze': coarse(maze(17, 2, corridor=3)),
    'warehouse': coarse(warehouse(30, 1, pallets=0.01)),
    'field': coarse(random_field(24, 5, share=0.05)),
}


DETOUR_MAX = {'optimal': 2.5, 'reward': 20.0}  # for the rule as in the benchmark of unknown terrain


def shortest_way(walls, start, goal):
    """The shortest way of a robot that knows the world and keeps its margin [m]."""
    room = clearance(walls, 0.1) <= RADIUS + DrivingSettings().clearance_margin
    ends = (tuple(int(10.0 * v) for v in reversed(place)) for place in (start, goal))
    return 0.1 * shortest_route(room, *ends).length


@pytest.mark.parametrize('mode', ['optimal', 'reward'])
@pytest.mark.parametrize('world', WORLDS)
def test_the_robot_gets_through_unknown_worlds(mode, world):
    walls = WORLDS[world]
    start, goal = roomy_place(walls, 1.0, 1.0), roomy_place(walls, 7.5, 9.5)
    drive = GridDrive(walls, PlanarPose(*start, 0.0), mode=mode)
    drive.pilot.set_goal(goal_at(*goal, 1.0))
    last = drive.run(900.0, until=(DriveState.REACHED, DriveState.UNREACHABLE))
    assert last.state is DriveState.REACHED, last.detail
    assert drive.way() < DETOUR_MAX[mode] * shortest_way(walls, start, goal)
    assert drive.pose.distance_to(goal_at(*goal)) <= 0.1
    assert abs(drive.pose.turn_to(goal_at(*goal, 1.0))) <= 0.11


def test_the_way_is_hardly_longer_than_it_must_be_and_the_route_is_kept():
    drive = GridDrive(wall_with_door(), PlanarPose(2.0, 1.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 1.0))
    drive.run(120.0)
    around = 2.0 * math.hypot(3.0, 3.8)
    assert drive.way() < 1.3 * around
    assert drive.pilot.keeper.plans < 25


def test_velocities_stay_within_all_limits():
    settings = DrivingSettings()
    drive = GridDrive(wall_with_door(), PlanarPose(2.0, 1.0, 2.0), settings)
    drive.pilot.set_goal(goal_at(8.0, 1.0))
    drive.run(120.0)
    given = [d.velocity for d in drive.drives if d.velocity is not None]
    forward = np.array([v.forward for v in given])
    turn = np.array([v.turn_rate for v in given])
    assert np.abs(forward).max() <= settings.max_linear_velocity
    assert np.abs(turn).max() <= settings.max_angular_velocity
    assert np.abs(np.diff(forward)).max() <= settings.max_linear_acceleration * TICK + 1e-9
    assert np.abs(np.diff(turn)).max() <= settings.max_angular_acceleration * TICK + 1e-9
    assert forward.max() > 0.4


def test_the_robot_is_slower_near_obstacles():
    walls = hall()
    walls[:26, 40:60] = walls[-26:, 40:60] = True  # a passage of 0.8 m
    drive = GridDrive(walls, PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    assert drive.run(120.0).state is DriveState.REACHED
    speeds = {'in': [], 'before': []}
    for pose, done in zip(drive.poses, drive.drives, strict=False):
        if done.velocity is not None and (4.2 < pose.x < 5.8 or 2.0 < pose.x < 3.2):
            speeds['in' if pose.x > 4.0 else 'before'].append(done.velocity.forward)
    assert max(speeds['in']) < 0.9 * max(speeds['before'])


def test_a_goal_behind_walls_is_told_unreachable_and_the_robot_stands():
    walls = hall()
    walls[20:40, [70, 90]] = True
    walls[[20, 39], 70:91] = True
    drive = GridDrive(walls, PlanarPose(2.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 3.0))
    last = drive.run(200.0, until=(DriveState.UNREACHABLE, DriveState.REACHED))
    assert last.state is DriveState.UNREACHABLE
    assert last.detail == 'no way to the goal: no free way leads to the goal'
    assert is_standing(drive.run(2.0))


def test_a_goal_in_a_known_obstacle_is_told_and_the_robot_stands():
    drive = GridDrive(wall_with_door(), PlanarPose(4.0, 3.0, 0.0))
    drive.tick()
    drive.pilot.set_goal(goal_at(5.1, 3.0))
    last = drive.run(1.0)
    assert last.state is DriveState.UNREACHABLE
    assert 'the goal is in or too near to an obstacle' in last.detail
    assert drive.way() < 1e-6


def test_a_goal_that_is_too_far_away_for_any_map_is_told():
    drive = GridDrive(hall(), PlanarPose(2.0, 3.0, 0.0))
    drive.tick()
    drive.pilot.set_goal(goal_at(1e6, 1e6))
    last = drive.run(0.5)
    assert last.state is DriveState.UNREACHABLE
    assert 'give a nearer goal' in last.detail
    assert drive.way() < 1e-6


def test_a_goal_that_is_not_finite_is_refused():
    drive = GridDrive(hall(), PlanarPose(2.0, 3.0, 0.0))
    with pytest.raises(DrivingError, match='the goal is not finite'):
        drive.pilot.set_goal(goal_at(math.nan, 0.0))


@pytest.mark.parametrize(
    ('sense', 'state'), [('senses_pose', DriveState.LOST), ('senses_map', DriveState.BLIND)]
)
def test_without_poses_or_frames_the_robot_stops_and_goes_on_with_them(sense, state):
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    drive.run(4.0)
    setattr(drive, sense, False)
    last = drive.run(4.0)
    assert last.state is state
    assert is_standing(last)
    lost_at = drive.pose
    drive.run(1.0)
    assert drive.pose.distance_to(lost_at) < 1e-6
    setattr(drive, sense, True)
    assert drive.run(60.0).state is DriveState.REACHED


def test_before_the_first_pose_and_frame_nothing_moves():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.senses_pose = drive.senses_map = False
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    assert 'there is no pose' in drive.run(0.5).detail
    drive.senses_pose = True
    assert 'no frame came yet' in drive.run(0.5).detail
    assert drive.way() == 0.0


def test_poses_that_jump_stop_the_robot():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    drive.run(4.0)
    drive.senses_pose = False
    drive.pilot.robot_at(drive.robot.time, None)
    last = drive.run(3.0)
    assert (last.state, last.detail) == (DriveState.LOST, 'the pose is not known: poses jump')
    assert is_standing(last)


def test_the_lamps_slow_stop_and_turn_the_robot():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    drive.run(3.0)
    drive.pilot.obey(LightCommand('slow', 0.15))
    drive.run(2.0)
    assert drive.run(0.5).velocity.forward == pytest.approx(0.15, abs=0.01)
    drive.pilot.obey(LightCommand('turn', math.pi))
    before = drive.pose.yaw
    drive.run(0.5)
    assert drive.drives[-1].state is DriveState.TURNING
    drive.run(5.0, until=(DriveState.DRIVING,))
    assert abs(drive.pose.yaw - before) == pytest.approx(math.pi, abs=0.06)
    drive.pilot.obey(LightCommand('stop', 0.0))
    assert drive.run(2.0).state is DriveState.HELD
    assert is_standing(drive.drives[-1])
    drive.pilot.obey(LightCommand('resume', 0.0))
    assert drive.run(60.0).state is DriveState.REACHED


def test_a_robot_too_near_to_a_wall_leaves_by_the_way_of_growing_clearance():
    drive = GridDrive(hall(), PlanarPose(1.0, 0.34, 0.0))
    drive.pilot.set_goal(goal_at(5.0, 3.0))
    assert drive.run(60.0).state is DriveState.REACHED
    assert min(drive.room) >= drive.room[0] - 0.01


def test_an_obstacle_that_appears_on_the_route_is_driven_around():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    drive.run(6.0)
    ahead = round(drive.pose.x / 0.1) + 10
    drive.walls[20:40, ahead : ahead + 3] = True
    assert drive.run(120.0).state is DriveState.REACHED
    assert drive.pilot.keeper.plans >= 2


def test_a_cleared_map_is_seen_anew_and_the_goal_stays():
    drive = GridDrive(wall_with_door(), PlanarPose(2.0, 1.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 1.0))
    drive.run(5.0)
    drive.known.clear()
    drive.pilot.map_cleared()
    assert drive.run(120.0).state is DriveState.REACHED


def test_a_known_map_is_used_before_anything_is_seen():
    walls = wall_with_door()
    drive = GridDrive(walls, PlanarPose(2.0, 1.0, 0.0))
    drive.known.write(LocalMap(drive.frame, (100 * walls).astype(np.int8), np.ones_like(walls)))
    drive.pilot.set_goal(goal_at(8.0, 1.0))
    assert drive.run(120.0).state is DriveState.REACHED
    assert drive.pilot.keeper.plans == 1


def test_when_time_jumps_back_the_robot_stands_without_a_goal():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(9.0, 3.0))
    drive.run(3.0)
    drive.pilot.time_jumped()
    assert drive.run(3.0).state is DriveState.IDLE
    assert drive.drives[-1].velocity is None
    last_given = [d.velocity for d in drive.drives if d.velocity is not None][-1]
    assert last_given == Velocity()


def test_the_robot_does_not_overshoot_its_goal():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(5.0, 3.0))
    assert drive.run(60.0).state is DriveState.REACHED
    drive.run(2.0, until=())
    assert max(pose.x for pose in drive.poses) < 5.05


def test_the_speed_allows_to_stop_before_what_lies_straight_ahead():
    settings = DrivingSettings(max_linear_velocity=4.0)
    drive = GridDrive(hall(), PlanarPose(1.0, 0.45, -0.2), settings)
    drive.sense()
    drive.pilot.set_goal(goal_at(8.0, 0.45))
    for k in range(100):  # the robot is held where it is
        drive.pilot.robot_at(TICK * k, drive.pose)
        drive.pilot.map_changed(TICK * k, drive.frame)
        speed = drive.pilot.step(TICK * k).velocity.forward
    to_wall = (0.45 - 0.1 - RADIUS) / math.sin(0.2)
    assert 0.1 < speed < math.sqrt(2.0 * settings.max_linear_acceleration * to_wall) * (1.0 - 0.2 / 0.6)


def test_after_the_goal_is_reached_no_push_makes_the_robot_drive_again():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(3.0, 3.0))
    drive.run(60.0)
    drive.run(0.5, until=())
    for place in (PlanarPose(4.0, 3.0, 2.0), None):
        drive.pilot.robot_at(drive.robot.time, place)
        done = drive.pilot.step(drive.robot.time + 100.0)
        assert (done.state, done.velocity) == (DriveState.REACHED, None)
    drive.pilot.set_goal(goal_at(6.0, 3.0))
    assert drive.run(60.0).state is DriveState.REACHED
    assert drive.pose.x > 5.8


def test_a_turn_that_nobody_could_make_is_not_made_later():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.run(1.0)
    drive.pilot.obey(LightCommand('turn', 3.0))
    drive.pilot.set_goal(goal_at(3.0, 3.0))
    drive.run(3.0)
    assert DriveState.TURNING not in {each.state for each in drive.drives}
    drive.pilot.obey(LightCommand('turn', 3.0))
    drive.pilot.robot_at(drive.robot.time, None)
    drive.run(2.0)
    assert DriveState.TURNING not in {each.state for each in drive.drives}


@pytest.mark.parametrize('resolution', [0.05, 0.1, 0.2])
@pytest.mark.parametrize('start', [(1.0, 2.93), (1.07, 3.1), (1.13, 2.97)])
def test_no_passage_is_entered_that_is_too_narrow_for_cells_so_large(resolution, start):
    walls = np.zeros((round(6.0 / resolution), round(10.0 / resolution)), dtype=bool)
    walls[[0, -1]] = walls[:, [0, -1]] = True
    part = slice(round(4.0 / resolution), round(6.0 / resolution))
    low, high = round(2.8 / resolution), round(3.4 / resolution)
    walls[:low, part] = walls[high:, part] = True
    drive = GridDrive(walls, PlanarPose(*start, 0.0), resolution=resolution)
    drive.pilot.set_goal(goal_at(8.0, 3.1))
    last = drive.run(60.0, until=(DriveState.REACHED, DriveState.UNREACHABLE))
    assert last.state in (DriveState.REACHED, DriveState.UNREACHABLE), last.detail


def test_a_robot_that_cannot_go_on_says_so(monkeypatch):
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 3.0))
    drive.run(2.0)
    monkeypatch.setattr(drive.pilot, '_speed', lambda *_: 0.0)
    assert drive.run(4.0).state is DriveState.DRIVING
    assert drive.run(4.0).state is DriveState.STUCK
    monkeypatch.undo()
    assert drive.run(60.0).state is DriveState.REACHED


def test_a_lamp_that_leaves_no_speed_holds_the_robot():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 3.0))
    drive.run(2.0)
    drive.pilot.obey(LightCommand('slow', 0.0))
    assert drive.run(2.0).state is DriveState.HELD
    assert is_standing(drive.drives[-1])


def test_the_robot_turns_for_a_lamp_once_it_stands():
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 3.0))
    drive.run(3.0)
    begun = len(drive.drives)
    drive.pilot.obey(LightCommand('turn', 1.0))
    drive.run(3.0)
    turning = [each.velocity for each in drive.drives[begun:] if each.state is DriveState.TURNING]
    spins = [each.forward for each in turning if abs(each.turn_rate) > 0.3]
    assert spins
    assert max(spins) < 0.02


@pytest.mark.parametrize('what', ['pose', 'frame'])
def test_what_comes_from_the_future_is_not_believed_for_ever(what):
    drive = GridDrive(hall(), PlanarPose(1.0, 3.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 3.0))
    drive.run(2.0)
    ahead = drive.robot.time + 30.0
    if what == 'pose':
        drive.pilot.robot_at(ahead, drive.pose)
        drive.senses_pose = False
    else:
        drive.pilot.map_changed(ahead, drive.frame)
        drive.senses_map = False
    last = drive.run(3.0)
    assert last.state is (DriveState.LOST if what == 'pose' else DriveState.BLIND)
    assert is_standing(last)


def test_a_cleared_map_forgets_its_obstacles():
    drive = GridDrive(wall_with_door(), PlanarPose(2.0, 1.0, 0.0))
    drive.pilot.set_goal(goal_at(8.0, 1.0))
    drive.run(2.0)
    drive.walls = hall()
    drive.known.clear()
    drive.pilot.map_cleared()
    before = drive.way()
    assert drive.run(120.0).state is DriveState.REACHED
    assert drive.way() - before < 6.5


def test_the_robot_never_drives_backwards_nor_fast_on_what_is_occupied():
    drive = GridDrive(wall_with_door(), PlanarPose(2.0, 1.0, 2.0), DrivingSettings(max_linear_velocity=2.0))
    drive.pilot.set_goal(goal_at(8.0, 1.0))
    assert drive.run(120.0).state is DriveState.REACHED
    speeds = [each.velocity.forward for each in drive.drives if each.velocity is not None]
    assert min(speeds) >= 0.0
