"""Planning beside the control cycle: snapshots, no waiting, and a fresh look at the path ahead."""

from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import pytest
from grid_drive import GridDrive, goal_at, hall, is_stopped, wall_with_door

from reward_planner.core.driving.drive_state import DriveState, Velocity, VelocitySmoother
from reward_planner.core.driving.replanner import path_length
from reward_planner.core.mapping.global_map import LocalMap
from reward_planner.core.occupancy_map import OCCUPIED, GridFrame
from reward_planner.core.route.route import thin_path
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2


class LateRun:
    """Runs planning cycles when the test wants it."""

    def __init__(self):
        self.waiting = []

    def __call__(self, work):
        future = Future()
        self.waiting.append((future, work))
        return future

    def finish(self, drive):
        """Run all waiting cycles, and then a control cycle of the drive."""
        waiting, self.waiting = self.waiting, []
        for future, work in waiting:
            future.set_result(work())
        drive.tick()


def late_drive(walls=None):
    """A drive whose routes are late."""
    drive = GridDrive(hall() if walls is None else walls, SE2(1.0, 3.0, 0.0))
    drive.controller.run_planning = LateRun()
    drive.controller.set_goal(goal_at(9.0, 3.0))
    return drive, drive.controller.run_planning


def test_until_the_first_route_the_robot_stands_and_reports_that_it_plans():
    drive, run = late_drive()
    for _ in range(30):
        drive.tick()
        assert (drive.drives[-1].state, drive.drives[-1].velocity) == (DriveState.PLANNING, Velocity())
    assert len(run.waiting) == 1  # one cycle at a time
    run.finish(drive)
    assert drive.drives[-1].state is DriveState.DRIVING


def test_a_robot_whose_next_route_is_late_follows_the_last_one_and_stops_before_what_appears():
    drive, run = late_drive()
    drive.tick()
    run.finish(drive)
    drive.run(3.95)
    assert drive.drives[-1].velocity.forward > 0.4
    ahead = round(drive.pose.x / 0.1) + 12
    drive.walls[20:40, ahead : ahead + 3] = True
    drive.run(6.0)  # hits nothing
    assert is_stopped(drive.drives[-1])
    assert drive.pose.x > 0.1 * ahead - 0.9
    for _ in range(1200):
        run.finish(drive)
    assert drive.drives[-1].state is DriveState.GOAL_REACHED


def test_a_planning_cycle_sees_the_map_as_it_was_at_its_start():
    drive, run = late_drive()
    drive.tick()
    before = drive.global_map.snapshot()
    walls = np.full(drive.frame.shape, OCCUPIED, dtype=np.int8)
    drive.global_map.write(LocalMap(drive.frame, walls, np.ones(drive.frame.shape, dtype=bool)))
    drive.controller.update_cells(drive.frame)
    assert (before.occupancy_in(drive.frame) != drive.global_map.occupancy_in(drive.frame)).any()
    drive.senses_map = False
    run.finish(drive)  # takes the route of before and starts a cycle with the walls
    assert len(drive.controller.points_map) > 50
    run.finish(drive)
    assert len(drive.controller.points_map) == 0


def test_a_cleared_map_discards_the_cycle_that_runs():
    drive, run = late_drive()
    drive.tick()
    drive.controller.reset_map()
    drive.run(0.3)
    run.finish(drive)
    assert drive.drives[-1].state is DriveState.PLANNING
    run.finish(drive)
    assert drive.drives[-1].state is DriveState.DRIVING


def test_the_way_around_somebody_begins_unless_the_route_is_kept_and_ends_when_he_has_left():
    drive = GridDrive(hall(), SE2(1.0, 3.0, 0.0), DrivingSettings(replan_period=60.0))
    drive.controller.set_goal(goal_at(9.0, 3.0))
    drive.run(0.3)
    planning, now = drive.controller.replanner, 0.4
    direct = path_length(planning.points_map)
    frame = GridFrame(5.0, 0.0, 0.1, 1, 50)
    planning.set_obstacles(LocalMap(frame, np.full(frame.shape, OCCUPIED, np.int8), np.ones(frame.shape, bool)))
    planning.is_kept = True
    planning.update(now, drive.pose)
    assert path_length(planning.points_map) == pytest.approx(direct)
    planning.is_kept = False
    planning.update(now, drive.pose)
    assert path_length(planning.points_map) > direct + 1.0
    planning.set_obstacles(None)
    planning.update(now, drive.pose)
    assert path_length(planning.points_map) == pytest.approx(direct)


def test_a_failed_cycle_is_reported_once_and_planning_starts_again():
    drive, run = late_drive()
    drive.tick()
    run.waiting.pop()[0].set_exception(ZeroDivisionError('a mistake'))
    with pytest.raises(ZeroDivisionError):
        drive.tick()
    drive.tick()
    run.finish(drive)
    assert drive.drives[-1].state is DriveState.DRIVING


def test_a_drive_with_a_thread_gets_around_the_wall():
    with ThreadPoolExecutor(1) as pool:
        drive = GridDrive(wall_with_door(), SE2(2.0, 1.0, 0.0))
        drive.controller.run_planning = pool.submit
        drive.controller.set_goal(goal_at(8.0, 1.0))
        assert drive.run(200.0).state is DriveState.GOAL_REACHED


def test_a_thin_path_keeps_its_ends_and_stays_near_the_route():
    corner = np.linspace(0.0, 40.0, 801)
    path = np.concatenate([np.stack([corner, 0.0 * corner], 1), np.stack([40.0 + 0.0 * corner, corner], 1)])
    thin = thin_path(path, 0.02)
    assert len(thin) < 510
    np.testing.assert_allclose(thin[[0, -1]], path[[0, -1]])
    assert np.hypot(*(thin - (40.0, 0.0)).T).min() < 0.03
    np.testing.assert_array_equal(thin_path(path[:900], 0.02), path[:900])


def test_the_smoother_drives_backwards_only_towards_a_target_behind():
    smoother = VelocitySmoother(DrivingSettings())
    for target in (0.4, -0.1, 0.3, 0.0):
        for _ in range(60):
            speed = smoother.step_toward(Velocity(target), 0.05).forward
            assert speed >= -0.1 - 1e-9
        assert speed == pytest.approx(target, abs=1e-6)
