"""The whole paper in a closed loop: three cameras, voxels by count, look around, reward rule, to the goal (2, 3.3)."""

import math
from dataclasses import replace

import numpy as np
import pytest
from grid_drive import GridDrive, goal_at, hall
from test_navigator import ROOMS, SETTINGS, RoomDrive

from reward_planner.core.depth.stereo_pair import pair_from_projections
from reward_planner.core.depth.trinocular_depth import TrinocularDepth, points_from_depth_image
from reward_planner.core.driving.drive_state import DriveState
from reward_planner.core.navigator import NavigatorSettings
from reward_planner.core.occupancy_map import FREE, OCCUPIED
from reward_planner.core.settings import DepthSettings, DrivingSettings, PlannerSettings, RewardSettings, VoxelSettings
from scene_simulator.room.room_drive import CameraRig, render_picture
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

PAPER = NavigatorSettings(
    voxels=VoxelSettings(rule='count', resolution=0.1, range_max=3.5),
    planner=PlannerSettings(mode='reward'),
    reward=RewardSettings(visits='counted'),
    driving=DrivingSettings(look_around=True),
)
MOUNT = CameraMount((0.1, 0.0, 0.5), (-math.pi / 2.0, 0.0, -math.pi / 2.0))
RIG = CameraRig(PinholeCamera(160, 120, 120.0, 120.0, 79.5, 59.5), MOUNT, 0.1)


class PaperDrive(RoomDrive):
    """A robot with three cameras in an L, as in figure 1."""

    def __init__(self, boxes):
        super().__init__(boxes, PAPER)
        left, right, top = (RIG.projections[name] for name in ('left', 'right', 'top'))
        pairs = pair_from_projections(left, right), pair_from_projections(left, top)
        self.depth = TrinocularDepth(*pairs, DepthSettings(disparities=32, fusion='union'))

    def points(self):
        images = (render_picture(self.room, RIG.camera, view, 1.0, self.rng) for view in RIG.views(self.pose).values())
        return points_from_depth_image(self.depth.compute(*images).depth, RIG.camera)


@pytest.mark.newest_set_only
def test_three_cameras_and_the_reward_rule_lead_to_the_goal():
    drive = PaperDrive(ROOMS['box'])
    drive.navigator.controller.set_goal(SE2(4.5, 0.0, 0.0))
    states, way, before = set(), 0.0, drive.pose
    for _ in range(900):
        states.add(drive.tick().state)
        way, before = way + before.distance_to(drive.pose), drive.pose
        if drive.drive.state is DriveState.GOAL_REACHED:
            break
    assert drive.drive.state is DriveState.GOAL_REACHED, drive.drive.detail
    assert DriveState.LOOKING_AROUND in states
    assert drive.gap > 0.0
    assert way < 9.0
    frame, cells = drive.navigator.mapper.map.occupancy()
    solid = drive.room.solid_cells((frame.origin_x, frame.origin_y), frame.resolution, frame.shape, (0.1, 1.2))
    assert (solid & (cells == FREE)).sum() < 0.02 * (cells == FREE).sum()
    assert (cells == OCCUPIED).sum() > 50


def test_the_robot_looks_around_once_at_the_start_and_not_where_the_map_is_known():
    drive = GridDrive(hall(), SE2(2.0, 3.0, 0.5), DrivingSettings(look_around=True))
    drive.senses_map = False
    drive.controller.update_map(0.0, drive.frame)
    drive.controller.set_goal(goal_at(5.0, 3.0))
    turned, before = 0.0, drive.pose.yaw
    for _ in range(400):
        drive.controller.update_map(drive.robot.time, drive.frame)
        drive.tick()
        if drive.drives[-1].state is not DriveState.LOOKING_AROUND:
            break
        turned, before = turned + math.remainder(drive.pose.yaw - before, math.tau), drive.pose.yaw
    assert turned == pytest.approx(math.tau, abs=0.1)
    assert drive.way() < 0.001
    drive.senses_map = True
    assert drive.run(60.0).state is DriveState.GOAL_REACHED
    looked = [command.state is DriveState.LOOKING_AROUND for command in drive.drives]
    assert not any(np.diff(np.flatnonzero(looked)) > 1)


def test_a_planned_route_is_that_of_the_mode():
    """The reward rule goes straight at the box and then around it; the shortest route turns aside at once."""
    lengths, asides = {}, {}
    for mode in ('optimal', 'reward'):
        planner, reward = PlannerSettings(mode=mode), RewardSettings(visits='counted')
        drive = RoomDrive(ROOMS['box'], replace(SETTINGS, planner=planner, reward=reward))
        for _ in range(5):
            drive.tick()
        points = drive.navigator.route_between(SE2(0.0, 0.0, 0.0), SE2(4.5, 0.0, 0.0), drive.robot.time)
        assert points[-1] == pytest.approx([4.5, 0.0])
        lengths[mode] = np.hypot(*np.diff(points, axis=0).T).sum()
        asides[mode] = np.abs(points[points[:, 0] < 0.8, 1]).max()
    assert lengths['optimal'] <= lengths['reward'] < 3.0 * lengths['optimal']
    assert asides['reward'] < 0.2 < asides['optimal']
