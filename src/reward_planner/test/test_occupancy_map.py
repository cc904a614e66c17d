"""Tests of occupancy maps."""

import numpy as np
import pytest

from reward_planner.core.occupancy_map import GridFrame, OccupancyMap
from reward_planner.core.reward_planner_error import RewardPlannerError


def test_what_is_unknown_is_not_occupied() -> None:
    grid = OccupancyMap(GridFrame(0.0, 0.0, 1.0, 5, 1), np.array([[-1, 0, 64, 65, 100]], dtype=np.int8))
    assert grid.occupied().tolist() == [[False, False, False, True, True]]


def test_an_array_of_another_shape_is_refused() -> None:
    with pytest.raises(RewardPlannerError, match='rows and columns'):
        OccupancyMap(GridFrame(0.0, 0.0, 1.0, 5, 1), np.zeros((5, 1), dtype=np.int8))
