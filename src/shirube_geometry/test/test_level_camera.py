import math

import numpy as np
import pytest

from shirube_geometry import CameraMount, level_camera


def test_a_robot_that_stands_level_has_its_mount():
    mount = CameraMount((0.1, -0.2, 0.3), (0.4, 0.5, -0.6))
    level = level_camera(mount)
    assert level.rotation == pytest.approx(mount.rotation)
    assert level.position == pytest.approx([0.1, -0.2, 0.3])


def test_a_camera_ahead_sinks_when_the_nose_goes_down():
    level = level_camera(CameraMount((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), pitch=0.1)
    assert level.position == pytest.approx([math.cos(0.1), 0.0, -math.sin(0.1)])


def test_a_camera_to_the_left_rises_when_the_robot_rolls():
    level = level_camera(CameraMount((0.0, 1.0, 0.0), (0.0, 0.0, 0.0)), roll=0.1)
    assert level.position == pytest.approx([0.0, math.cos(0.1), math.sin(0.1)])


def test_what_is_above_the_robot_keeps_its_distance():
    mount = CameraMount((0.3, 0.1, 0.2), (0.2, -0.1, 1.0))
    level = level_camera(mount, 0.2, -0.3)
    assert np.linalg.norm(level.position) == pytest.approx(np.linalg.norm(mount.xyz))
    assert level.rotation @ level.rotation.T == pytest.approx(np.eye(3), abs=1e-12)
