"""The costmap covers what is needed, and partial updates equal a full computation."""

from __future__ import annotations

import numpy as np
import pytest

from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.mapping.global_map import GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, GridFrame
from reward_planner.core.reward_planner_error import DrivingError


def seen(rng, column, row, share):
    """A square of 30 x 30 cells of 0.1 m, some occupied."""
    frame = GridFrame(0.1 * column, 0.1 * row, 0.1, 30, 30)
    cells = np.where(rng.random((30, 30)) < share, OCCUPIED, FREE).astype(np.int8)
    return LocalMap(frame, cells, np.ones((30, 30), dtype=bool))


def test_parts_that_are_refreshed_equal_the_whole():
    rng = np.random.default_rng(1)
    global_map = GlobalMap(0.1, 1_000_000)
    costmap = InflatedCostmap(0.35, 0.8)
    costmap.cover(global_map, [(-3.0, -3.0), (12.0, 9.0)])
    for _ in range(25):
        part = seen(rng, int(rng.integers(-20, 80)), int(rng.integers(-20, 60)), 0.02)
        global_map.write(part)
        before = costmap.blocked.copy()
        cells = costmap.refresh(global_map, part.frame)
        changed = np.zeros_like(before)
        changed[tuple(cells.T)] = True
        np.testing.assert_array_equal(changed, before != costmap.blocked)
    fresh = InflatedCostmap(0.35, 0.8)
    fresh.cover(global_map, [(-3.0, -3.0), (12.0, 9.0)])
    xy = rng.uniform((-3.0, -3.0), (12.0, 9.0), (2000, 2))
    np.testing.assert_allclose(costmap.clearance_at(xy), fresh.clearance_at(xy), atol=1e-6)


def test_the_costmap_grows_only_when_it_must_and_leaves_room_around():
    global_map = GlobalMap(0.1, 1_000_000)
    costmap = InflatedCostmap(0.3, 0.6)
    assert costmap.cover(global_map, [(0.0, 0.0), (5.0, 5.0)])
    assert not costmap.cover(global_map, [(1.0, 1.0), (5.0, 5.0)])
    global_map.write(seen(np.random.default_rng(2), 70, 0, 1.0))
    assert costmap.cover(global_map, [(1.0, 1.0), (5.0, 5.0)])
    assert not costmap.blocked[[0, -1]].any()
    assert not costmap.blocked[:, [0, -1]].any()
    assert costmap.clearance_at((1e3, 1e3)) == pytest.approx(0.6)


def test_a_costmap_beyond_all_memory_is_rejected():
    global_map, costmap = GlobalMap(0.1, 1_000_000), InflatedCostmap(0.3, 0.6)
    for goal, words in ((1e5, 'give a nearer goal or a larger resolution'), (102.0, 'cells_max is 1000000')):
        with pytest.raises(DrivingError, match=words):
            costmap.cover(global_map, [(0.5, 0.5), (goal, goal)])
    assert costmap.cover(global_map, [(0.5, 0.5), (95.0, 95.0)])


def test_a_costmap_that_grows_keeps_what_it_covered():
    global_map, costmap = GlobalMap(0.1, 1_000_000), InflatedCostmap(0.3, 0.6)
    costmap.cover(global_map, [(0.0, 0.0), (20.0, 3.0)])
    before = costmap.frame
    assert costmap.cover(global_map, [(0.0, 0.0), (3.0, 20.0)])
    corners = before.centre_of([(0, 0), (before.rows - 1, before.columns - 1)])
    assert costmap.frame.contains(costmap.frame.cell_of(corners)).all()
    assert not costmap.cover(global_map, [(20.0, 3.0), (3.0, 20.0)])
    assert costmap.cover(global_map, [(5e4, 5e4)])  # too large with what it covered: drops that
    assert costmap.clearance_at((5e4, 5e4)) == pytest.approx(0.6)
    assert costmap.frame.rows * costmap.frame.columns <= global_map.cells_max


def test_of_a_map_that_is_too_large_it_covers_the_part_around_robot_and_goal():
    global_map = GlobalMap(0.1, 400_000)
    rng = np.random.default_rng(3)
    near = seen(rng, 10, 10, 0.05)
    for part in (near, seen(rng, 2000, 1500, 0.05)):
        global_map.write(part)
    costmap = InflatedCostmap(0.3, 0.6)
    assert costmap.cover(global_map, [(0.0, 0.0), (3.0, 0.0)])
    assert costmap.frame.rows * costmap.frame.columns <= 400_000
    whole = GlobalMap(0.1, 400_000)
    whole.write(near)
    alone = InflatedCostmap(0.3, 0.6)
    alone.cover(whole, [(0.0, 0.0), (3.0, 0.0)])
    places = rng.uniform(0.0, 4.0, (500, 2))
    np.testing.assert_allclose(costmap.clearance_at(places), alone.clearance_at(places), atol=1e-6)
    assert not costmap.cover(global_map, [(1.0, 2.0), (3.0, 0.0)])
    assert costmap.cover(global_map, [(198.0, 148.0), (201.0, 150.0)])
    assert not costmap.cover(global_map, [(199.0, 149.0), (201.0, 150.0)])
    assert costmap.clearance_at(200.05 + 0.1 * np.arange(29)[:, None] * (1.0, 0.0) + (0.0, -50.0)).min() < 0.6
