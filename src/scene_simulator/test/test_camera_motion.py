"""Interpolated poses during a frame match the sampled poses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from scene_simulator.camera_motion import CameraMotion, CameraPose, camera_pose
from shirube_core.geometry import SE2, CameraMount, matrix_from_rpy

MOUNT = CameraMount((0.1, -0.05, 0.4), (0.02, -0.01, math.pi / 2.0))


def moving(time: float) -> CameraPose:
    """A robot that drives 1 m/s in a bend of 1.5 rad/s."""
    return camera_pose(SE2(math.sin(1.5 * time) / 1.5, 0.2, 1.5 * time), MOUNT)


def test_a_camera_is_where_the_robot_carries_it() -> None:
    robot = SE2(1.0, 2.0, math.pi / 2.0)
    pose = camera_pose(robot, MOUNT)
    # A quarter turn to the left takes ahead to +y and left to -x.
    np.testing.assert_allclose(pose.position, [1.0 + 0.05, 2.0 + 0.1, 0.4], atol=1e-12)
    np.testing.assert_allclose(pose.rotation, matrix_from_rpy((0.0, 0.0, robot.yaw)) @ MOUNT.rotation)


def test_points_of_the_map_go_to_the_camera_and_back() -> None:
    pose = moving(0.3)
    points = np.random.default_rng(0).uniform(-3.0, 3.0, (20, 3))
    back = pose.camera_points(points) @ pose.rotation.T + pose.position
    np.testing.assert_allclose(back, points, atol=1e-12)


def test_poses_between_the_knots_are_the_true_ones() -> None:
    motion = CameraMotion(moving, 1.0, 1.016)
    times = np.linspace(1.0, 1.016, 41)
    positions, rotations = motion.poses(times)
    for time, position, rotation in zip(times, positions, rotations, strict=True):
        true = moving(float(time))
        np.testing.assert_allclose(position, true.position, atol=5e-6)
        np.testing.assert_allclose(rotation, true.rotation, atol=1e-9)
    np.testing.assert_array_equal(motion.pose(float(times[7])).position, positions[7])


def test_a_camera_at_rest_stays_where_it_is() -> None:
    motion = CameraMotion(lambda _: moving(1.0), 0.0, 0.01)
    positions, rotations = motion.poses(np.linspace(0.0, 0.01, 5))
    np.testing.assert_allclose(positions, np.tile(moving(1.0).position, (5, 1)), atol=1e-12)
    assert rotations[3] == pytest.approx(moving(1.0).rotation, abs=1e-12)
