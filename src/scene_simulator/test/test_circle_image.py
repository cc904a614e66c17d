"""The picture of a circle is the ellipse on which the pictures of its points lie."""

from __future__ import annotations

import math

import numpy as np
import pytest
from circle_image import circle_image

from scene_simulator.corridor.shapes import RoundLandmark, facing_wall
from scene_simulator.imaging.exposure import camera_pose
from shirube_core.geometry import SE2, CameraMount, PinholeCamera

CAMERA = PinholeCamera(320, 240, 306.0, 305.0, 158.3, 121.1)
MOUNT = CameraMount((0.1, 0.12, 1.2), (-math.pi / 2.0 + 0.03, 0.04, -math.pi / 2.0 + 0.02))
METER = RoundLandmark('meter', facing_wall(0.0), (0.4, 1.3), 0.25)


@pytest.mark.parametrize('pose', [SE2(-2.6, 0.0, 0.0), SE2(-3.0, 0.4, -0.26), SE2(-2.0, -1.0, 0.5)])
def test_the_ellipse_passes_through_projected_points_of_the_circle(pose: SE2) -> None:
    T_map_camera = camera_pose(pose, MOUNT)
    ellipse = circle_image(METER, CAMERA, T_map_camera)
    angles = np.linspace(0.0, math.tau, 50)
    rim = np.array(METER.centre) + METER.radius * np.column_stack([np.cos(angles), np.sin(angles)])
    pixels = CAMERA.pixels_from_points(T_map_camera.camera_points(METER.surface.points_map(rim)))
    cos, sin = math.cos(ellipse.tilt), math.sin(ellipse.tilt)
    along = (pixels - ellipse.centre) @ np.array([[cos, -sin], [sin, cos]])
    np.testing.assert_allclose(np.hypot(*(along / ellipse.semi_axes).T), 1.0, atol=1e-9)
    assert -math.pi / 2 <= ellipse.tilt <= math.pi / 2
    assert ellipse.semi_axes[0] > ellipse.semi_axes[1]


def test_the_picture_of_the_centre_is_not_the_centre_of_the_picture() -> None:
    T_map_camera = camera_pose(SE2(-2.0, -1.0, 0.5), MOUNT)
    ellipse = circle_image(METER, CAMERA, T_map_camera)
    centre = CAMERA.pixels_from_points(T_map_camera.camera_points([METER.points_map()['meter']]))[0]
    assert 0.3 < math.dist(ellipse.centre, centre) < 3.0
