"""The demo scene: its truth agrees with its pictures, seen through formulas of the test's own."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from scene_simulator.floor.demo_scene import DEMO_CAMERA, DemoScene

SCENE = DemoScene()


def pixels_by_hand(points: NDArray[np.float64], time: float) -> NDArray[np.float64]:
    """Project map points, shape (n, 2), with the body's motion and lens written out, shape (n, 2) [px]."""
    pose, (heave, roll, pitch) = SCENE.pose_at(time), SCENE.suspension.motion_at(time)
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    dx, dy = points[:, 0] - pose.x, points[:, 1] - pose.y
    level = np.column_stack([c * dx + s * dy, c * dy - s * dx, np.full(len(dx), -heave)])
    about_x = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    about_y = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    body = level @ (about_y @ about_x)
    depth = 0.13 - body[:, 2]
    x, y = -body[:, 1] / depth, -body[:, 0] / depth
    k1, k2, p1, p2, _ = DEMO_CAMERA.distortion
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2**2
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.column_stack([DEMO_CAMERA.fx * u + DEMO_CAMERA.cx, DEMO_CAMERA.fy * v + DEMO_CAMERA.cy])


@pytest.mark.parametrize('time', [0.0, 8.0, 29.3, 57.0])
def test_a_chip_is_in_the_picture_where_the_truth_puts_it(time: float) -> None:
    pose = SCENE.pose_at(time)
    floor = SCENE.worn_floor
    near = np.flatnonzero(np.hypot(*(floor.points - (pose.x, pose.y)).T) < 0.033)
    pixels = pixels_by_hand(floor.points[near], time)
    mount = SCENE.suspension.mount_at(time, SCENE.mount)
    np.testing.assert_allclose(SCENE.camera.project(floor.points[near], pose, mount), pixels, atol=1e-6)
    image = SCENE.photograph(time, np.random.default_rng(1)).image
    columns, rows = np.rint(pixels).astype(int).T
    dark = image[rows, columns] < 0.6 * np.median(image)
    assert len(near) > 10
    assert dark.mean() > 0.9


def test_only_the_filthy_stretch_hides_the_floor() -> None:
    clean, filthy = (SCENE.photograph(time, np.random.default_rng(1)) for time in (10.0, 49.2))
    assert clean.dirt_fraction < 0.03
    assert filthy.dirt_fraction > 0.9
