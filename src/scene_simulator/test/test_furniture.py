"""Furniture is where it is put, and a depth camera sees through it where it is open."""

from __future__ import annotations

import numpy as np
import pytest

from scene_simulator.box_room import BoxRoom
from scene_simulator.furniture import crate, overhang, rack, table

CORNER, CELL, SHAPE = (-1.0, -1.0), 0.05, (60, 60)
PIECES = {
    'crate': crate(0.5, 0.4, 0.6),
    'table': table(1.0, 0.7, 0.7),
    'rack': rack(1.2, 0.4, 1.6, 4),
    'turned shelf': rack(0.4, 1.2, 1.6, 4),
    'overhang': overhang(1.0, 0.4, 0.7, 1.4),
}


def ground(item, low, high):
    """Area that is solid at some heights [m^2]."""
    room = BoxRoom((-2.0, -2.0, 0.0, 4.0, 4.0, 2.5), item.boxes)
    return CELL**2 * room.solid_cells(CORNER, CELL, SHAPE, (low, high)).sum()


@pytest.mark.parametrize('name', PIECES)
def test_furniture_fills_its_footprint_at_any_position(name):
    x0, y0, x1, y1 = PIECES[name].translate(0.31, -0.17).footprint
    assert (x0, y0) == pytest.approx((0.31, -0.17))
    area = ground(PIECES[name], 0.0, 2.0)
    assert (x1 - x0) * (y1 - y0) <= area <= (x1 - x0 + 2 * CELL) * (y1 - y0 + 2 * CELL)


def test_under_a_table_are_only_its_legs():
    assert ground(PIECES['table'], 0.1, 0.6) < 0.1
    assert ground(PIECES['table'], 0.1, 0.69) > 0.7


@pytest.mark.parametrize('name', ['rack', 'turned shelf'])
def test_between_the_boards_of_a_rack_are_only_panels(name):
    assert ground(PIECES[name], 0.2, 0.5) < 0.15
    assert ground(PIECES[name], 0.0, 0.5) > 0.48


def test_under_an_overhang_is_nothing():
    assert ground(PIECES['overhang'], 0.0, 0.7) == 0.0


def test_distances_are_to_the_footprint():
    item = PIECES['crate'].translate(1.0, 1.0)
    distances = item.distances_to([(1.2, 1.2), (1.2, 0.7), (1.8, 1.8)])
    np.testing.assert_allclose(distances, [0.0, 0.3, 0.5])
