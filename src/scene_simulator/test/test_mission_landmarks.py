"""Landmarks are on the inside of their walls, the curtain hides those of one wall, boxes are painted where they are."""

from itertools import combinations

import numpy as np
import pytest

from scene_simulator.corridor.shapes import CorridorLight, shape_table
from scene_simulator.corridor.stereo_rig import FORWARD_MOUNT, StereoCamera, StereoOptics, render_pair
from scene_simulator.corridor.walls import RoomShell
from scene_simulator.imaging.exposure import camera_pose
from scene_simulator.mission.landmarks import (
    FurnishedScene,
    OrderedScene,
    bare_walls,
    box_shapes,
    covered_walls,
    landmarks_on_wall,
    sort_farthest_first,
)
from scene_simulator.mission.layout import NOMINAL, ROOM
from scene_simulator.mission.sensors import STEREO_RIG
from scene_simulator.room.box_room import BoxRoom
from shirube_core.geometry import SE2, PinholeCamera

CAMERA = PinholeCamera(160, 120, 130.0, 130.0, 79.5, 59.5)
BOXES = ((2.0, -0.5, 0.0, 2.6, 0.1, 0.9), (3.0, 0.0, 0.0, 3.5, 0.8, 1.0), (4.0, -1.0, 0.4, 4.4, 0.9, 0.8))


def test_painted_pixels_are_those_whose_rays_meet_a_box():
    pose = camera_pose(SE2(0.0, 0.1, -0.05), FORWARD_MOUNT)
    shapes = [shape for box in sort_farthest_first(BOXES, pose.position) for shape in box_shapes(box, 0.6)]
    scene = OrderedScene(shape_table(shapes), CorridorLight(0.9, (0.0, 0.0, 0.0)))
    painted = StereoCamera(CAMERA, StereoOptics(blur=0.0, vignetting=0.0)).light(scene, pose) > 0.05
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = pose.rotation, pose.position
    size = (-10.0, -10.0, -10.0, 10.0, 10.0, 10.0)
    seen, empty = (BoxRoom(size, boxes).depth_image(CAMERA, view) for boxes in (BOXES, ()))
    hit = seen < empty - 1e-3
    assert hit.mean() > 0.1
    assert (painted == hit).mean() > 0.97


def test_the_farthest_comes_first():
    eye = np.array([0.0, 0.0, 1.0])
    assert sort_farthest_first(BOXES, eye) == [BOXES[2], BOXES[1], BOXES[0]]
    assert sort_farthest_first(BOXES, np.array([8.0, 0.0, 1.0])) == [BOXES[0], BOXES[1], BOXES[2]]


WALLS = ('east', 'north', 'west')


@pytest.mark.parametrize(('wall', 'goal'), zip(WALLS, NOMINAL.goals))
def test_each_goal_looks_at_the_landmarks_of_its_wall(wall, goal):
    landmarks = landmarks_on_wall(bare_walls(), wall)
    points = np.array([p for landmark in landmarks for p in landmark.points_map().values()])
    camera = STEREO_RIG.camera_poses(goal)[0]
    in_camera = camera.camera_points(points)
    pixels = STEREO_RIG.left.intrinsics.pixels_from_points(in_camera)
    assert (in_camera[:, 2] > 1.5).all()
    assert ((pixels > 0.0) & (pixels < (752.0, 480.0))).all(axis=1).mean() > 0.75
    assert ((points >= ROOM[:3]) & (points <= ROOM[3:])).all()


@pytest.mark.parametrize('wall', WALLS)
def test_landmarks_of_a_wall_do_not_overlap(wall):
    objects = [each for each in landmarks_on_wall(bare_walls(), wall) if '/' not in each.name]
    assert len(objects) >= 7
    for one, other in combinations(objects, 2):
        (a, b), (c, d) = one.extent, other.extent
        assert b[0] < c[0] or d[0] < a[0] or b[1] < c[1] or d[1] < a[1], (one.name, other.name)


def test_the_normals_of_walls_point_into_the_room():
    shell, middle = RoomShell(ROOM), np.array([4.0, 3.0, 1.6])
    for name in ('south', 'west', 'north', 'east'):
        surface, length = shell.wall(name)
        assert (middle - surface.origin) @ surface.normal > 2.9
        end = surface.points_map([(length, 0.0)])[0]
        np.testing.assert_allclose(np.clip(end, ROOM[:3], ROOM[3:]), end, atol=1e-9)


def test_the_curtain_changes_every_picture_of_the_west_wall_and_none_of_the_others():
    for goal, is_covered in zip(NOMINAL.goals, (False, False, True)):
        eye = STEREO_RIG.camera_poses(goal)[0].position
        pictures = [
            render_pair(FurnishedScene(walls).order_for_camera(eye), STEREO_RIG, goal)[0].astype(float)
            for walls in (bare_walls(), covered_walls())
        ]
        changed = (np.abs(pictures[0] - pictures[1]) > 3.0).mean()
        assert changed > 0.5 if is_covered else changed == 0.0
