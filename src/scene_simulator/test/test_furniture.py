"""Furniture is where it is put, clear of each other and of the path, and open where it is open."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.room.box_room import BoxRoom
from scene_simulator.room.furniture import Furnishing, crate, furnish, overhang, rack, table

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


SIZE = (-4.0, -3.0, 0.0, 4.0, 3.0, 2.5)
WAY = np.stack([np.linspace(-3.0, 3.0, 200), np.zeros(200)], axis=1)


@pytest.mark.parametrize('seed', range(5))
def test_everything_is_there_and_nothing_touches(seed):
    room = furnish(SIZE, Furnishing(crates=3, tables=2, racks=2, overhangs=1), seed, WAY, 0.5)
    kinds = Counter(item.kind for item in room.furniture)
    assert kinds == {'crate': 3, 'table': 2, 'rack': 2, 'overhang': 1}
    for one, other in combinations(room.furniture, 2):
        a, b = one.footprint, other.footprint
        assert a[2] < b[0] or b[2] < a[0] or a[3] < b[1] or b[3] < a[1]
    for item in room.furniture:
        x0, y0, x1, y1 = item.footprint
        assert min(x0 - SIZE[0], y0 - SIZE[1], SIZE[3] - x1, SIZE[4] - y1) > -1e-9
        assert item.distances_to(WAY).min() >= 0.5


def test_racks_and_overhangs_are_at_walls():
    room = furnish(SIZE, Furnishing(), 3, WAY, 0.5)
    for item in room.furniture:
        if item.kind in ('rack', 'overhang'):
            gaps = np.abs(np.array(item.footprint) - (SIZE[0], SIZE[1], SIZE[3], SIZE[4]))
            assert gaps.min() < 1e-9


def test_furniture_that_does_not_fit_is_an_error():
    with pytest.raises(SceneError, match='no free position for another item'):
        furnish((-1.0, -1.0, 0.0, 1.0, 1.0, 2.5), Furnishing(crates=20), 1, [], 0.5)
    with pytest.raises(SceneError, match='seed'):
        furnish(SIZE, Furnishing(), -1, WAY, 0.5)
