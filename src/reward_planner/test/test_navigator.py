"""From depth images of a furnished room to the goal: mapping, planning and control without ROS."""

import math
from contextlib import suppress

import numpy as np
import pytest
from simulated_robot import MotorLimits, SimulatedRobot

from reward_planner.core.driving.drive_state import DriveState
from reward_planner.core.driving.light_command import LightCommand
from reward_planner.core.mapping.global_map import LocalMap
from reward_planner.core.mapping.pose_buffer import DropReason, PoseStatus
from reward_planner.core.navigator import Navigator, NavigatorSettings, SensorFrame
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import DrivingError, RewardPlannerError
from reward_planner.core.route.route import NoRoute
from reward_planner.core.settings import MappingSettings, VoxelSettings
from scene_simulator.room.box_room import BoxRoom, add_disparity_noise, forward_camera, points_from_depth
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(120, 90, 90.0, 90.0, 59.5, 44.5)
MOUNT = CameraMount((0.1, 0.0, 0.5), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
SIZE = (-1.0, -2.5, 0.0, 6.0, 2.5, 2.6)
ROOMS = {
    'box': ((1.5, -0.5, 0.0, 2.0, 0.6, 0.8),),
    'table': (
        (2.0, -1.2, 0.7, 3.2, 0.9, 0.75),
        *((x, y, 0.0, x + 0.06, y + 0.06, 0.7) for x in (2.0, 3.14) for y in (-1.2, 0.84)),
    ),
    'wall with a door': ((2.5, -2.5, 0.0, 2.7, 0.9, 2.0), (2.5, 2.1, 0.0, 2.7, 2.5, 2.0)),
}
RADIUS = 0.2
SETTINGS = NavigatorSettings(voxels=VoxelSettings(resolution=0.1, range_max=4.0))


class RoomDrive:
    """A robot with a depth camera in a room."""

    def __init__(self, boxes, settings=SETTINGS):
        self.room = BoxRoom(SIZE, boxes)
        self.navigator = Navigator(MOUNT, settings)
        self.robot = SimulatedRobot(SE2(0.0, 0.0, 0.0), MotorLimits(0.6, 4.0))
        self.rng = np.random.default_rng(1)
        self.gap = math.inf
        self.drive = None

    @property
    def pose(self):
        return self.robot.pose_at(self.robot.time)

    def points(self):
        camera = self.pose @ SE2(*MOUNT.xyz[:2], 0.0)
        depth = self.room.depth_image(CAMERA, forward_camera(camera.x, camera.y, MOUNT.xyz[2], camera.yaw))
        return points_from_depth(add_disparity_noise(depth, 9.0, 0.1, self.rng), CAMERA).astype(np.float32)

    def tick(self):
        now = self.robot.time
        self.navigator.add_frame(now, now, SensorFrame(self.points(), CAMERA.fx))
        self.navigator.add_pose(now, self.pose)
        try:
            self.navigator.process_frames(now)
        finally:  # as the node does it
            self.apply_command(now)
        return self.drive

    def apply_command(self, now):
        self.drive = drive = self.navigator.controller.step(now)
        velocity = drive.velocity
        forward, turn = (0.0, 0.0) if velocity is None else (velocity.forward, velocity.turn_rate)
        self.robot.drive(forward, turn, now + 0.1)
        self.gap = min(self.gap, self._gap())

    def _gap(self):
        x, y = self.pose.x, self.pose.y
        gaps = [x - SIZE[0], y - SIZE[1], SIZE[3] - x, SIZE[4] - y]
        gaps += [
            math.hypot(max(x0 - x, 0.0, x - x1), max(y0 - y, 0.0, y - y1)) for x0, y0, _, x1, y1, _ in self.room.boxes
        ]
        return min(gaps) - RADIUS


@pytest.mark.parametrize('name', ROOMS)
def test_a_robot_with_a_depth_camera_gets_through_a_room_and_hits_nothing(name):
    drive = RoomDrive(ROOMS[name])
    drive.navigator.controller.set_goal(SE2(5.0, 0.0, 0.0))
    for _ in range(900):
        state = drive.tick().state
        if state is DriveState.GOAL_REACHED:
            break
    assert state is DriveState.GOAL_REACHED
    assert drive.gap > 0.0


NEAR_POINTS = np.tile(np.array([[0.0, 0.0, 0.1]], dtype=np.float32), (CAMERA.width * CAMERA.height, 1))


@pytest.mark.parametrize('hidden', [1.0, 0.9])
def test_a_robot_whose_camera_is_covered_stops_and_hits_nothing(hidden):
    drive = RoomDrive(ROOMS['wall with a door'])
    drive.navigator.controller.set_goal(SE2(5.0, -1.5, 0.0))
    for _ in range(12):
        drive.tick()
    see, before = drive.points, drive.navigator.mapper.map.occupancy()[1]
    count = int(hidden * len(NEAR_POINTS))
    drive.points = lambda: np.concatenate([NEAR_POINTS[:count], see()[count:]])
    for _ in range(60):
        with pytest.raises(RewardPlannerError, match='nothing covers the camera'):
            drive.tick()
    np.testing.assert_array_equal(drive.navigator.mapper.map.occupancy()[1], before)
    assert drive.drive.state is DriveState.MAP_STALE
    stood = drive.pose
    with pytest.raises(RewardPlannerError):
        drive.tick()
    assert drive.pose.distance_to(stood) < 1e-3
    assert drive.gap > 0.0


def test_a_robot_turns_past_an_obstacle_that_fills_the_view():
    drive, states = RoomDrive(((0.32, -0.6, 0.0, 0.6, 0.6, 2.0),)), set()
    drive.robot = SimulatedRobot(SE2(0.0, 0.0, 1.1), MotorLimits(0.6, 4.0))
    for k in range(500):
        with suppress(RewardPlannerError):
            drive.tick()
        states.add(drive.drive.state)
        if k < 27:
            drive.robot.drive(0.0, -0.6, drive.robot.time + 0.1)  # somebody turns it towards the obstacle
        elif k == 60:
            drive.navigator.controller.set_goal(SE2(0.0, -1.8, -1.6))
            drive.navigator.controller.apply_command(LightCommand('stop', 0.0))
        elif k == 80:  # not while a lamp stops it
            assert drive.drive.state is DriveState.STOPPED_BY_LAMP
            drive.navigator.controller.apply_command(LightCommand('resume', 0.0))
    assert states >= {DriveState.RECOVERING, DriveState.GOAL_REACHED}
    assert drive.gap > 0.0


def test_a_robot_whose_camera_is_covered_slowly_turns_once_around_at_most():
    drive, turned = RoomDrive(ROOMS['wall with a door']), 0.0
    drive.navigator.controller.set_goal(SE2(5.0, -1.5, 0.0))
    see = drive.points
    for k in range(250):
        count = int(min(0.05 * max(k - 12, 0), 1.0) * len(NEAR_POINTS))
        drive.points = lambda count=count: np.concatenate([NEAR_POINTS[:count], see()[count:]])
        before = drive.pose
        with suppress(RewardPlannerError):
            drive.tick()
        turned += abs(before.yaw_to(drive.pose)) if k > 30 else 0.0
    assert drive.drive.state is DriveState.MAP_STALE
    assert 5.0 < turned < 7.5
    assert drive.gap > 0.0


def test_a_wall_close_ahead_does_not_blind_a_robot_that_sees_past_it():
    drive = RoomDrive(())
    points = drive.points()
    points[: len(points) // 2] = (0.0, 0.0, 0.1)
    drive.navigator.add_pose(1.0, drive.pose)
    drive.navigator.add_frame(1.0, 1.0, SensorFrame(points, CAMERA.fx))
    assert len(drive.navigator.process_frames(1.0)) == 1


def test_when_time_jumps_back_goal_and_frames_are_forgotten():
    drive = RoomDrive(())
    drive.navigator.controller.set_goal(SE2(5.0, 0.0, 0.0))
    for _ in range(40):
        drive.tick()
    drive.navigator.add_frame(9.0, 9.0, SensorFrame(drive.points(), CAMERA.fx))
    drive.navigator.handle_time_jump()
    assert drive.navigator.add_pose(1.0, drive.pose) is PoseStatus.ACCEPTED
    assert drive.navigator.message_filter.dropped[DropReason.TIME_JUMP] == 1
    assert drive.navigator.controller.step(1.0).state is DriveState.IDLE
    drive.navigator.add_frame(1.0, 1.0, SensorFrame(drive.points(), CAMERA.fx))
    assert len(drive.navigator.process_frames(1.0)) == 1


def test_goals_must_be_on_a_known_map_or_where_something_was_seen_since():
    drive = RoomDrive(())
    navigator = drive.navigator
    navigator.set_goal(SE2(40.0, 0.0, 0.0))  # without a static map every goal is allowed
    cells = np.zeros((20, 20), dtype=np.int8)
    navigator.set_static_map(OccupancyMap(GridFrame(-1.0, -1.0, 0.1, 20, 20), cells))
    navigator.set_goal(SE2(0.9, 0.9, 0.0))
    with pytest.raises(DrivingError, match=r'outside of the map, which extends from x -1\.00 to 1\.00 m'):
        navigator.set_goal(SE2(2.0, 0.0, 0.0))
    assert navigator.controller.goal == SE2(0.9, 0.9, 0.0)
    here = SE2(0.0, 0.0, 0.0)
    assert navigator.route_between(here, SE2(2.0, 0.0, 0.0), 0.0) is NoRoute.GOAL_OUTSIDE
    assert navigator.route_between(SE2(2.0, 0.0, 0.0), here, 0.0) is NoRoute.START_OUTSIDE
    for _ in range(5):
        drive.tick()
    navigator.set_goal(SE2(2.0, 0.0, 0.0))
    navigator.clear_map()
    navigator.set_goal(SE2(40.0, 0.0, 0.0))


def test_clearing_around_a_place_keeps_what_is_far_and_the_static_map():
    navigator = RoomDrive(()).navigator
    frame = GridFrame(-3.0, -3.0, 0.1, 60, 60)
    walls = np.zeros(frame.shape, dtype=np.int8)
    walls[:, 0] = walls[25, 35:45] = 100
    navigator.set_static_map(OccupancyMap(frame, walls))
    seen = np.zeros(frame.shape, dtype=bool)
    seen[40, 20:60] = True
    navigator.mapper.map.write(LocalMap(frame, np.full(frame.shape, 100, dtype=np.int8), seen))
    navigator.clear_around(SE2(0.0, 0.0, 0.0), 1.5)
    x, y = np.moveaxis(frame.centre_of(np.moveaxis(np.indices(frame.shape), 0, -1)), -1, 0)
    expected = np.where(seen & (np.hypot(x, y) > 1.5), 100, walls)
    np.testing.assert_array_equal(navigator.mapper.map.occupancy_in(frame), expected)


@pytest.mark.parametrize(('rows', 'columns'), [(998, 998), (2000, 600), (40, 30_000), (830, 830)])
def test_a_known_map_for_which_there_is_no_room_is_refused_and_on_the_largest_routes_are_found(rows, columns):
    settings = NavigatorSettings(VoxelSettings(resolution=0.1), MappingSettings(cells_max=1_000_000))
    known = OccupancyMap(GridFrame(0.0, 0.0, 0.1, columns, rows), np.zeros((rows, columns), dtype=np.int8))
    navigator = Navigator(MOUNT, settings)
    if rows == 830:
        navigator.set_static_map(known)
        assert len(navigator.route_between(SE2(0.0, 0.0, 0.0), SE2(82.9, 82.9, 0.0), 0.0)) > 800
        return
    with pytest.raises(RewardPlannerError, match=f'{columns} x {rows} cells.*cells_max 1000000; raise') as e:
        navigator.set_static_map(known)
    assert '\n' not in str(e.value)
