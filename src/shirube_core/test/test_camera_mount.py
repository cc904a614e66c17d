"""The pose of a camera on a tilted robot, and its projection to the floor."""

import math

import numpy as np
import pytest

from shirube_core.geometry import CameraMount, PinholeCamera, gravity_aligned_camera


def test_without_tilt_the_pose_is_that_of_the_mount():
    mount = CameraMount((0.1, -0.2, 0.3), (0.4, 0.5, -0.6))
    aligned = gravity_aligned_camera(mount)
    assert aligned.rotation == pytest.approx(mount.rotation)
    assert aligned.position == pytest.approx([0.1, -0.2, 0.3])


def test_a_camera_ahead_sinks_when_the_nose_goes_down_and_one_on_the_left_rises_when_the_robot_rolls():
    ahead = gravity_aligned_camera(CameraMount((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), pitch=0.1)
    assert ahead.position == pytest.approx([math.cos(0.1), 0.0, -math.sin(0.1)])
    left = gravity_aligned_camera(CameraMount((0.0, 1.0, 0.0), (0.0, 0.0, 0.0)), roll=0.1)
    assert left.position == pytest.approx([0.0, math.cos(0.1), math.sin(0.1)])


def test_the_default_mount_has_the_image_top_ahead_and_the_image_left_on_the_left():
    camera = PinholeCamera(235, 235, 339.44, 339.44, 117.0, 117.0)
    rays = camera.rays_from_pixels([[117.0, 0.0], [0.0, 117.0]])
    reach = 117.0 / 339.44 * 0.13
    np.testing.assert_allclose(CameraMount().floor_points_from_rays(rays), [[reach, 0.0], [0.0, reach]], atol=1e-12)


def test_floor_points_are_where_the_rays_to_them_meet_the_floor():
    mount, points = CameraMount((0.1, 0.0, 0.5), (math.pi - 0.3, 0.1, -1.0)), [[0.3, 0.2], [0.0, -0.4]]
    rays = mount.camera_points_from_floor(points)
    np.testing.assert_allclose(mount.floor_points_from_rays(rays), points, atol=1e-12)
    assert np.isnan(mount.floor_points_from_rays(-rays)).all()
