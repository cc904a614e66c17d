"""On an escape path the clearance grows with each step."""

from __future__ import annotations

import numpy as np

from reward_planner.core.driving.replanner import escape_path
from reward_planner.core.occupancy_map import clearance


def test_each_step_gains_clearance_and_the_last_is_free():
    rng = np.random.default_rng(3)
    found = 0
    for _ in range(50):
        occupied = rng.random((40, 40)) < 0.004
        room = clearance(occupied, 0.1)
        blocked = room <= 0.45
        inside = np.argwhere(blocked & (room > 0.0))
        start = tuple(int(n) for n in inside[rng.integers(len(inside))])
        out = escape_path(room, blocked, start)
        if out is None:
            continue
        found += 1
        along = room[out[:, 0], out[:, 1]]
        assert (np.diff(along) > 0.0).all()
        assert blocked[tuple(out[:-1].T)].all()
        assert not blocked[tuple(out[-1])]
        assert (np.abs(np.diff(out, axis=0)).max(axis=1) == 1).all()
    assert found > 25


def test_a_free_start_is_its_own_escape_path():
    room = np.full((5, 5), 1.0, dtype=np.float32)
    out = escape_path(room, np.zeros((5, 5), dtype=bool), (2, 3))
    assert out is not None
    assert out.tolist() == [[2, 3]]


def test_a_passage_that_is_too_narrow_has_none():
    occupied = np.zeros((20, 9), dtype=bool)
    occupied[:, [0, 8]] = True
    room = clearance(occupied, 0.1)
    assert escape_path(room, room <= 0.6, (10, 2)) is None
