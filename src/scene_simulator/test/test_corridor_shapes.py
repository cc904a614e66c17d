"""Planes as seen by the viewer; light that changes evenly in space changes evenly on every plane."""

import numpy as np
import pytest

from scene_simulator.corridor.shapes import CorridorLight, facing_wall
from scene_simulator.corridor.walls import CorridorShell


def test_the_end_wall_faces_the_robot_with_right_on_its_right() -> None:
    wall = facing_wall(1.0, 0.5)
    np.testing.assert_array_equal(wall.normal, [-1.0, 0.0, 0.0])
    np.testing.assert_allclose(wall.points_map([(0.3, 1.5)]), [[1.0, 0.2, 1.5]])
    np.testing.assert_allclose(wall.offset_plane(0.1).points_map([(0.3, 1.5)]), [[0.9, 0.2, 1.5]])


def test_side_walls_face_each_other() -> None:
    shell = CorridorShell()
    np.testing.assert_array_equal(shell.left_wall.normal, [0.0, -1.0, 0.0])
    np.testing.assert_array_equal(shell.right_wall.normal, [0.0, 1.0, 0.0])


def test_planes_that_meet_have_the_same_light_there() -> None:
    shell, light = CorridorShell(), CorridorLight(0.8, (0.02, 0.1, -0.05))
    edge = np.array([0.0, 0.5 * shell.width, 1.9])
    found = []
    for surface in (shell.surface, shell.left_wall):
        level, right, up = light.on_surface(surface)
        offset = edge - surface.origin
        found.append(level + right * (offset @ surface.right) + up * (offset @ surface.up))
    expected = 0.8 * (1.0 + 0.1 * 0.5 * shell.width - 0.05 * 0.6)
    assert found == pytest.approx([expected, expected])
