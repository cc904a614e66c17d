"""Planes: right and up axes as seen by the viewer."""

from __future__ import annotations

import numpy as np

from scene_simulator.corridor_shell import CorridorShell
from scene_simulator.corridor_surface import facing_wall


def test_the_end_wall_faces_the_robot_with_right_on_its_right() -> None:
    wall = facing_wall(1.0, 0.5)
    np.testing.assert_array_equal(wall.normal, [-1.0, 0.0, 0.0])
    np.testing.assert_allclose(wall.points_map([(0.3, 1.5)]), [[1.0, 0.2, 1.5]])
    np.testing.assert_allclose(wall.offset_plane(0.1).points_map([(0.3, 1.5)]), [[0.9, 0.2, 1.5]])


def test_side_walls_face_each_other() -> None:
    shell = CorridorShell()
    np.testing.assert_array_equal(shell.left_wall.normal, [0.0, -1.0, 0.0])
    np.testing.assert_array_equal(shell.right_wall.normal, [0.0, 1.0, 0.0])
