"""Tests of the true path lengths, on small grids."""

import numpy as np
import pytest

from scene_simulator.grid_truth import distances_from, is_traversable

CORNER = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]], dtype=bool)


def test_distances_are_octile_in_the_open() -> None:
    distances = distances_from(np.zeros((4, 6), dtype=bool), (0, 0))
    assert distances[3, 5] == pytest.approx(2.0 + 3.0 * 2.0**0.5)
    assert distances[0, 5] == 5.0


def test_corners_are_gone_around_and_walls_are_never_reached() -> None:
    distances = distances_from(CORNER, (0, 1))
    assert distances[1, 2] == 2.0
    assert distances[2, 1] == 4.0
    assert np.isinf(distances[1, 1])


@pytest.mark.parametrize(
    ('cells', 'can'),
    [
        ([(0, 0), (0, 1), (0, 2), (1, 2)], True),
        ([(0, 0)], True),
        ([(0, 1), (1, 2)], False),
        ([(0, 1), (1, 1), (2, 1)], False),
        ([(0, 0), (0, 2)], False),
        ([(0, 0), (0, 0)], False),
    ],
)
def test_only_steps_to_free_neighbours_past_no_corner_can_be_driven(cells, can: bool) -> None:
    assert is_traversable(CORNER, np.array(cells)) == can
