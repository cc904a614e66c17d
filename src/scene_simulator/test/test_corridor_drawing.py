"""Drawn shapes have the requested sizes, letters form a row; planes as seen by the viewer, and the light on them."""

import itertools
import math

import numpy as np
import pytest

from scene_simulator.corridor.drawing import ADVANCE, Drawing, circle, text_strokes
from scene_simulator.corridor.shapes import CorridorLight, Paint, facing_wall
from scene_simulator.corridor.walls import CorridorShell
from scene_simulator.floor.dot_floor import polygon_areas

LETTERS = '0123456789ABCDEFGHIKLMNOPRSTUVWXY'


def test_every_letter_is_in_its_box_and_two_pairs_are_twins() -> None:
    drawn = {letter: list(text_strokes(letter)) for letter in LETTERS}
    for strokes in drawn.values():
        points = np.concatenate(strokes)
        assert points.min() >= 0.0
        assert points[:, 0].max() <= 0.6
        assert points[:, 1].max() == 1.0
        assert all(len(stroke) > 1 for stroke in strokes)
        assert all((np.abs(np.diff(stroke, axis=0)).max(axis=1) > 0.0).all() for stroke in strokes)
    pairs = itertools.combinations(LETTERS, 2)
    assert [(a, b) for a, b in pairs if str(drawn[a]) == str(drawn[b])] == [('0', 'O'), ('5', 'S')]


def test_letters_advance_and_a_blank_stays_blank() -> None:
    (first,), (second,) = list(text_strokes('L')), list(text_strokes(' L'))
    np.testing.assert_allclose(second - first, [(ADVANCE, 0.0)] * 3)


INK = Paint(0.1)


@pytest.mark.parametrize('radius', [0.002, 0.1, 0.6])
def test_a_circle_has_the_area_of_the_circle_and_hardly_leaves_it(radius: float) -> None:
    outline = circle(radius)
    assert polygon_areas(outline[None])[0] == pytest.approx(math.pi * radius**2)
    ends = np.hypot(*outline.T)
    middles = np.hypot(*(0.5 * (outline + np.roll(outline, 1, axis=0))).T)
    assert np.abs(np.concatenate([ends, middles]) - radius).max() < 1.1e-5


def test_a_stroke_covers_its_line_and_half_its_width_around() -> None:
    drawing = Drawing(facing_wall(0.0), (0.5, 1.0))
    drawing.stroke([(0.0, 0.0), (0.3, 0.0)], 0.02, INK)
    _, y, z = drawing.shapes[0].points.T
    assert (-y.max(), -y.min()) == pytest.approx((0.49, 0.81))
    assert (z.min(), z.max()) == pytest.approx((0.99, 1.01))


def test_text_is_centred_on_its_position() -> None:
    drawing = Drawing(facing_wall(0.0))
    drawing.text('HH', (0.2, 1.0), 0.1, INK)
    points = np.concatenate([shape.points for shape in drawing.shapes])
    assert -0.5 * (points[:, 1].min() + points[:, 1].max()) == pytest.approx(0.2)
    assert (points[:, 2].min(), points[:, 2].max()) == pytest.approx((0.942, 1.058))
    assert all(shape.paint is INK for shape in drawing.shapes)


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
