"""When the robot stops: stale input, commands of lamps, and at the goal."""

import math

import pytest
from grid_drive import GridDrive, goal_at, hall, hall_drive, is_stopped

from reward_planner.core.driving.drive_state import DriveState, Velocity
from reward_planner.core.driving.light_command import LightCommand
from shirube_core.geometry import SE2


@pytest.mark.parametrize(('sense', 'state'), [('senses_pose', DriveState.LOST), ('senses_map', DriveState.MAP_STALE)])
def test_without_poses_or_frames_the_robot_stops_and_goes_on_with_them(sense, state):
    drive = hall_drive(9.0, 4.0)
    setattr(drive, sense, False)
    last = drive.run(4.0)
    assert last.state is state
    assert is_stopped(last)
    lost_at = drive.pose
    drive.run(1.0)
    assert drive.pose.distance_to(lost_at) < 1e-6
    setattr(drive, sense, True)
    assert drive.run(60.0).state is DriveState.GOAL_REACHED


def test_poses_that_jump_stop_the_robot_and_before_the_first_pose_and_frame_nothing_moves():
    drive = hall_drive(9.0, 4.0)
    drive.senses_pose = False
    drive.controller.update_pose(drive.robot.time, None)
    last = drive.run(3.0)
    assert (last.state, last.detail) == (DriveState.LOST, 'no valid pose: the pose jumped')
    assert is_stopped(last)
    drive = GridDrive(hall(), SE2(1.0, 3.0, 0.0))
    drive.senses_pose = drive.senses_map = False
    drive.controller.set_goal(goal_at(9.0, 3.0))
    assert 'no pose received' in drive.run(0.5).detail
    drive.senses_pose = True
    assert 'no frame received' in drive.run(0.5).detail
    assert drive.way() == 0.0


def test_the_lamps_slow_stop_and_turn_the_robot():
    drive = hall_drive(9.0, 3.0)
    drive.controller.apply_command(LightCommand('slow', 0.15))
    drive.run(2.0)
    assert drive.run(0.5).velocity.forward == pytest.approx(0.15, abs=0.01)
    drive.controller.apply_command(LightCommand('turn', math.pi))
    before = drive.pose.yaw
    drive.run(0.5)
    assert drive.drives[-1].state is DriveState.TURNING
    drive.run(5.0, until=(DriveState.DRIVING,))
    assert abs(drive.pose.yaw - before) == pytest.approx(math.pi, abs=0.06)
    for operation in ('stop', 'slow'):  # a lamp that leaves no speed holds the robot
        drive.controller.apply_command(LightCommand(operation, 0.0))
        assert drive.run(2.0).state is DriveState.STOPPED_BY_LAMP
        assert is_stopped(drive.drives[-1])
        drive.controller.apply_command(LightCommand('resume', 0.0))
    assert drive.run(60.0).state is DriveState.GOAL_REACHED


def test_when_time_jumps_back_the_robot_stops_without_a_goal():
    drive = hall_drive(9.0, 3.0)
    drive.controller.handle_time_jump()
    assert drive.run(3.0).state is DriveState.IDLE
    assert drive.drives[-1].velocity is None
    last_given = [d.velocity for d in drive.drives if d.velocity is not None][-1]
    assert last_given == Velocity()


def test_after_the_goal_is_reached_no_push_makes_the_robot_drive_again():
    drive = hall_drive(3.0, 60.0)
    drive.run(0.5, until=())
    for place in (SE2(4.0, 3.0, 2.0), None):
        drive.controller.update_pose(drive.robot.time, place)
        done = drive.controller.step(drive.robot.time + 100.0)
        assert (done.state, done.velocity) == (DriveState.GOAL_REACHED, None)
    drive.controller.set_goal(goal_at(6.0, 3.0))
    assert drive.run(60.0).state is DriveState.GOAL_REACHED
    assert drive.pose.x > 5.8


def test_a_turn_that_nobody_could_make_is_not_made_later():
    drive = GridDrive(hall(), SE2(1.0, 3.0, 0.0))
    drive.run(1.0)
    drive.controller.apply_command(LightCommand('turn', 3.0))
    drive.controller.set_goal(goal_at(3.0, 3.0))
    drive.run(3.0)
    assert DriveState.TURNING not in {each.state for each in drive.drives}
    drive.controller.apply_command(LightCommand('turn', 3.0))
    drive.controller.update_pose(drive.robot.time, None)
    drive.run(2.0)
    assert DriveState.TURNING not in {each.state for each in drive.drives}


def test_a_robot_that_cannot_go_on_says_so(monkeypatch):
    drive = hall_drive(8.0, 2.0)
    monkeypatch.setattr(drive.controller, '_allowed_speed', lambda *_: 0.0)
    assert drive.run(4.0).state is DriveState.DRIVING
    assert drive.run(4.0, until=(DriveState.STUCK,)).state is DriveState.STUCK
    # Each recovery behavior is tried, with the route in between; then the robot stays stuck.
    drive.run(90.0, until=())
    assert drive.drives[-1].state is DriveState.STUCK
    tried = dict.fromkeys(each.detail for each in drive.drives if each.state is DriveState.RECOVERING)
    assert ['look' in ''.join(tried), 'back up' in ''.join(tried), 'clear' in ''.join(tried)] == [True] * 3
    monkeypatch.undo()
    assert drive.run(60.0).state is DriveState.GOAL_REACHED


def test_the_robot_turns_for_a_lamp_once_it_is_stopped():
    drive = hall_drive(8.0, 3.0)
    begun = len(drive.drives)
    drive.controller.apply_command(LightCommand('turn', 1.0))
    drive.run(3.0)
    turning = [each.velocity for each in drive.drives[begun:] if each.state is DriveState.TURNING]
    spins = [each.forward for each in turning if abs(each.turn_rate) > 0.3]
    assert spins
    assert max(spins) < 0.02


@pytest.mark.parametrize(('sense', 'state'), [('senses_pose', DriveState.LOST), ('senses_map', DriveState.MAP_STALE)])
def test_stamps_in_the_future_are_not_accepted_for_ever(sense, state):
    drive = hall_drive(8.0, 2.0)
    setattr(drive, sense, False)
    if sense == 'senses_pose':
        drive.controller.update_pose(drive.robot.time + 30.0, drive.pose)
    else:
        drive.controller.update_map(drive.robot.time + 30.0, drive.frame)
    last = drive.run(3.0)
    assert last.state is state
    assert is_stopped(last)
