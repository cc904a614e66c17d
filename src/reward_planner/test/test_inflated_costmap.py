"""The costmap covers what is needed, and partial updates equal a full computation."""

import numpy as np
import pytest

from reward_planner.core.driving.inflated_costmap import InflatedCostmap
from reward_planner.core.mapping.global_map import CostmapMasks, GlobalMap, LocalMap
from reward_planner.core.occupancy_map import FREE, OCCUPIED, UNKNOWN, GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import DrivingError
from reward_planner.core.route.route import COST_MAX, LETHAL
from reward_planner.core.settings import PlannerSettings


def seen(rng, column, row, share):
    """A square of 30 x 30 cells of 0.1 m, some occupied."""
    frame = GridFrame(0.1 * column, 0.1 * row, 0.1, 30, 30)
    cells = np.where(rng.random((30, 30)) < share, OCCUPIED, FREE).astype(np.int8)
    return LocalMap(frame, cells, np.ones((30, 30), dtype=bool))


@pytest.mark.parametrize('settings', [PlannerSettings(), PlannerSettings(unknown='blocked')])
def test_parts_that_are_refreshed_equal_the_whole(settings):
    rng = np.random.default_rng(1)
    global_map = GlobalMap(0.1, 1_000_000)
    values = rng.choice([0, 40, 100], (50, 50)).astype(np.int8)
    global_map.masks = CostmapMasks(OccupancyMap(GridFrame(1.0, 2.0, 0.07, 50, 50), values))
    costmap = InflatedCostmap(0.35, 0.8, settings)
    costmap.cover(global_map, [(-3.0, -3.0), (12.0, 9.0)])
    for _ in range(25):
        part = seen(rng, int(rng.integers(-20, 80)), int(rng.integers(-20, 60)), 0.02)
        global_map.write(part)
        before = costmap.costs.copy()
        cells = costmap.refresh(global_map, part.frame)
        changed = np.zeros_like(before)
        changed[tuple(cells.T)] = True
        np.testing.assert_array_equal(changed, before != costmap.costs)
    fresh = InflatedCostmap(0.35, 0.8, settings)
    fresh.cover(global_map, [(-3.0, -3.0), (12.0, 9.0)])
    xy = rng.uniform((-3.0, -3.0), (12.0, 9.0), (2000, 2))
    np.testing.assert_allclose(costmap.clearance_at(xy), fresh.clearance_at(xy), atol=1e-6)
    (rows, columns), (other_rows, other_columns) = (each.frame.cell_of(xy).T for each in (costmap, fresh))
    np.testing.assert_array_equal(costmap.costs[rows, columns], fresh.costs[other_rows, other_columns])
    np.testing.assert_array_equal(costmap.blocked, costmap.costs > COST_MAX)


def test_costs_decay_with_the_distance_and_masks_and_unknown_cells_add_to_them():
    global_map = GlobalMap(0.1, 1_000_000)
    cells = np.full((40, 40), FREE, dtype=np.int8)
    cells[:, 0], cells[30:, 20:] = OCCUPIED, UNKNOWN
    local = LocalMap(GridFrame(0.0, 0.0, 0.1, 40, 40), cells, cells != UNKNOWN)
    global_map.write(local)
    mask = np.zeros((20, 20), dtype=np.int8)
    mask[0, 0], mask[1, :], mask[0, 4] = UNKNOWN, OCCUPIED, 50
    global_map.masks = CostmapMasks(OccupancyMap(GridFrame(2.0, 0.0, 0.1, 20, 20), mask))
    settings = PlannerSettings(inflation_radius=0.8, cost_scaling_factor=2.0, unknown='blocked')
    costmap = InflatedCostmap(0.3, 1.0, settings)
    costmap.cover(global_map, [(0.0, 0.0), (4.0, 4.0)])
    (row, column), *_ = costmap.frame.cell_of([(0.05, 0.05)])
    costs = costmap.costs[row : row + 40, column : column + 40]
    distances = 0.1 * np.arange(4, 9)
    assert (costs[15, :4] == LETHAL).all()
    np.testing.assert_allclose(costs[15, 4:9], 252 * np.exp(-2.0 * (distances - 0.3)), atol=0.51)
    assert not costs[15, 9:30].any()
    assert costs[0, 20] == 0
    assert costs[0, 24] == 127
    assert (costs[1, 20:] == LETHAL).all()
    assert (costmap.clearance_at([(2.5, 0.15), (2.5, 0.25)]) == [0.0, 1.0]).all()
    assert (costs[30:, 20:] == LETHAL).all()


def test_unknown_cells_behind_what_is_seen_cost_as_if_it_extended_there():
    global_map, frame = GlobalMap(0.1, 1_000_000), GridFrame(0.0, 0.0, 0.1, 40, 40)
    cells = np.full((40, 40), FREE, dtype=np.int8)
    cells[18:22, 10:30] = UNKNOWN
    cells[18:22, 10] = OCCUPIED  # the face of a box that is seen from the left
    global_map.write(LocalMap(frame, cells, cells != UNKNOWN))
    costmap = InflatedCostmap(0.3, 1.0, PlannerSettings())
    costmap.cover(global_map, [(0.0, 0.0), (4.0, 4.0)])
    row, column = costmap.frame.cell_of([(0.05, 0.05)])[0]
    costs = costmap.costs[row : row + 40, column : column + 40]
    assert (costs[20, 11:15] >= COST_MAX).all()  # within half a meter of the face
    assert costs[20, 25] == costs[5, 20] == 0
    assert not costmap.blocked[row + 20, column + 14]
    assert costmap.clearance_at([(1.45, 2.05)])[0] == pytest.approx(0.4)
    assert costmap.clearance_at([(1.45, 2.05)], is_cautious=True)[0] == 0.0


@pytest.mark.parametrize('scale', [0.03, 0.1, 0.25])
def test_no_cell_of_a_mask_is_lost_whatever_its_resolution(scale):
    rng = np.random.default_rng(4)
    values = np.where(rng.random((40, 40)) < 0.02, OCCUPIED, FREE).astype(np.int8)
    mask = OccupancyMap(GridFrame(0.31, -0.17, scale, 40, 40), values)
    frame = GridFrame(-1.0, -1.0, 0.1, 150, 150)
    costs = CostmapMasks(mask).keepout_costs(frame)
    centres = mask.frame.centre_of(np.argwhere(values == OCCUPIED))
    assert (costs[tuple(frame.cell_of(centres).T)] == LETHAL).all()
    places = frame.centre_of(np.argwhere(costs == LETHAL))
    assert np.abs(places[:, None] - centres).max(axis=2).min(axis=1).max() <= 0.5 * max(scale, 0.1) + 1e-9


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
