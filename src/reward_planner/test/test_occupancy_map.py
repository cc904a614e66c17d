"""Occupancy grids: geometry, cells and inflation."""

import math

import numpy as np
import pytest

from reward_planner.core.occupancy_map import GridFrame, OccupancyMap, clearance
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import LETHAL, inflation_costs
from reward_planner.core.settings import PlannerSettings


def test_what_is_unknown_is_not_occupied() -> None:
    grid = OccupancyMap(GridFrame(0.0, 0.0, 1.0, 5, 1), np.array([[-1, 0, 64, 65, 100]], dtype=np.int8))
    assert grid.occupied().tolist() == [[False, False, False, True, True]]


def test_an_array_of_another_shape_is_refused() -> None:
    with pytest.raises(RewardPlannerError, match='rows and columns'):
        OccupancyMap(GridFrame(0.0, 0.0, 1.0, 5, 1), np.zeros((5, 1), dtype=np.int8))


FRAME = GridFrame(origin_x=-2.0, origin_y=1.0, resolution=0.05, columns=80, rows=40)


def test_row_0_is_the_lowest_and_column_0_the_leftmost() -> None:
    assert FRAME.cell_of([-1.99, 1.01]).tolist() == [0, 0]
    assert FRAME.cell_of([1.99, 1.01]).tolist() == [0, 79]
    assert FRAME.cell_of([-1.99, 2.99]).tolist() == [39, 0]


def test_a_cell_is_that_of_its_centre() -> None:
    cells = np.argwhere(np.ones(FRAME.shape))
    np.testing.assert_array_equal(FRAME.cell_of(FRAME.centre_of(cells)), cells)
    points = np.random.default_rng(0).uniform(-10.0, 10.0, (1000, 2))
    assert np.abs(FRAME.centre_of(FRAME.cell_of(points)) - points).max() <= 0.025 + 1e-12


def test_cells_beyond_each_border_are_outside() -> None:
    points = [(-2.01, 2.0), (2.01, 2.0), (0.0, 0.99), (0.0, 3.01), (0.0, 2.0), (1e300, 2.0)]
    assert FRAME.contains(FRAME.cell_of(points)).tolist() == [False, False, False, False, True, False]


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf])
def test_a_point_that_is_not_finite_is_refused(value: float) -> None:
    with pytest.raises(RewardPlannerError, match='not finite'):
        FRAME.cell_of([value, 0.0])


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ((0.0, 0.0, 0.0, 1, 1), 'resolution'),
        ((0.0, 0.0, math.nan, 1, 1), 'resolution'),
        ((math.nan, 0.0, 1.0, 1, 1), 'origin'),
        ((0.0, 0.0, 1.0, 0, 1), 'cells'),
        ((0.0, 0.0, 1.0, 1, -1), 'cells'),
    ],
)
def test_a_grid_that_cannot_be_is_refused(changes: tuple[float, float, float, int, int], message: str) -> None:
    with pytest.raises(RewardPlannerError, match=message):
        GridFrame(*changes)


def distances_one_by_one(occupied: np.ndarray) -> np.ndarray:
    cells = np.argwhere(np.ones(occupied.shape))
    offsets = cells[:, None] - np.argwhere(occupied)[None]
    return np.hypot(offsets[..., 0], offsets[..., 1]).min(axis=1).reshape(occupied.shape)


def test_clearance_is_the_distance_to_the_nearest_obstacle() -> None:
    occupied = np.random.default_rng(1).random((40, 60)) < 0.02
    np.testing.assert_allclose(clearance(occupied, 0.05), 0.05 * distances_one_by_one(occupied), atol=1e-5)


@pytest.mark.parametrize('radius_cells', [0.0, 0.9, 1.0, math.sqrt(2.0), 5.0, 7.3])
def test_cells_within_the_radius_are_blocked_and_no_others(radius_cells: float) -> None:
    occupied = np.random.default_rng(2).random((50, 50)) < 0.01
    truth = distances_one_by_one(occupied) <= radius_cells + 1e-9
    costs = inflation_costs(clearance(occupied, 0.05), 0.05 * radius_cells, PlannerSettings())
    np.testing.assert_array_equal(costs == LETHAL, truth)
    assert not inflation_costs(clearance(np.zeros((5, 5), dtype=bool), 0.05), 0.1, PlannerSettings()).any()
