"""Boxes are painted where they are: at each pixel the painted face is the one that a ray meets."""

from __future__ import annotations

import numpy as np

from scene_simulator.box_room import BoxRoom
from scene_simulator.box_shapes import box_shapes, sort_farthest_first
from scene_simulator.camera_motion import camera_pose
from scene_simulator.corridor_light import CorridorLight
from scene_simulator.corridor_shape import shape_table
from scene_simulator.mission_landmarks import OrderedScene
from scene_simulator.stereo_camera import StereoCamera, StereoOptics
from scene_simulator.stereo_rig import FORWARD_MOUNT
from shirube_core.geometry import SE2, PinholeCamera

CAMERA = PinholeCamera(160, 120, 130.0, 130.0, 79.5, 59.5)
BOXES = (
    (2.0, -0.5, 0.0, 2.6, 0.1, 0.9),
    (3.0, 0.0, 0.0, 3.5, 0.8, 1.0),
    (4.0, -1.0, 0.4, 4.4, 0.9, 0.8),
)


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
