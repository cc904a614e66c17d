"""A furnished room has the requested items, clear of each other and of the path, and repeats with its seed."""

from __future__ import annotations

from collections import Counter
from itertools import combinations

import numpy as np
import pytest

from scene_simulator.errors import SceneError
from scene_simulator.furnished_room import Furnishing, furnish

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
        assert x0 > SIZE[0] - 1e-9
        assert y0 > SIZE[1] - 1e-9
        assert x1 < SIZE[3] + 1e-9
        assert y1 < SIZE[4] + 1e-9
        assert item.distances_to(WAY).min() >= 0.5


def test_racks_and_overhangs_are_at_walls():
    room = furnish(SIZE, Furnishing(), 3, WAY, 0.5)
    for item in room.furniture:
        if item.kind in ('rack', 'overhang'):
            gaps = np.abs(np.array(item.footprint) - (SIZE[0], SIZE[1], SIZE[3], SIZE[4]))
            assert gaps.min() < 1e-9


def test_the_seed_decides():
    one, same, other = (furnish(SIZE, Furnishing(), seed, WAY, 0.5) for seed in (1, 1, 2))
    assert one == same
    assert one != other


def test_furniture_that_does_not_fit_is_an_error():
    with pytest.raises(SceneError, match='no free position for another item'):
        furnish((-1.0, -1.0, 0.0, 1.0, 1.0, 2.5), Furnishing(crates=20), 1, [], 0.5)
    with pytest.raises(SceneError, match='seed'):
        furnish(SIZE, Furnishing(), -1, WAY, 0.5)
