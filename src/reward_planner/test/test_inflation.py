"""Clearance and inflation of obstacles."""

import math

import numpy as np
import pytest

from reward_planner.core.occupancy_map import clearance, inflate_obstacles


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
    np.testing.assert_array_equal(inflate_obstacles(occupied, 0.05, 0.05 * radius_cells), truth)


def test_nothing_is_blocked_where_nothing_is_occupied() -> None:
    assert not inflate_obstacles(np.zeros((5, 5), dtype=bool), 0.05, 0.5).any()
