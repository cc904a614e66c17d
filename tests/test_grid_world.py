"""The visible cells of a grid world, and true path lengths."""

import numpy as np
import pytest
from grid_world import GridWorld, distances_from, is_traversable

REACH = 6.0


def seen(occupied: np.ndarray, cell: tuple[int, int]) -> np.ndarray:
    cells, found = GridWorld(occupied).observe(cell, REACH)
    picture = np.zeros(occupied.shape, dtype=bool)
    picture[tuple(cells.T)] = True
    np.testing.assert_array_equal(found, occupied[tuple(cells.T)])
    return picture


def test_nothing_hides_a_disc_in_the_open() -> None:
    rows, columns = np.indices((30, 30))
    nearest = np.hypot(np.maximum(abs(rows - 14) - 0.5, 0.0), np.maximum(abs(columns - 15) - 0.5, 0.0))
    picture = seen(np.zeros((30, 30), dtype=bool), (14, 15))
    assert picture[nearest <= REACH - 0.1].all()
    assert not picture[nearest > REACH].any()


def test_a_wall_hides_what_is_behind_it_and_is_seen_itself() -> None:
    occupied = np.zeros((30, 30), dtype=bool)
    occupied[:, 18] = True
    picture = seen(occupied, (15, 15))
    assert picture[15, 18]
    assert not picture[:, 19:].any()


def test_neighbours_are_seen_unless_two_occupied_ones_close_the_gap() -> None:
    rng = np.random.default_rng(1)
    for _ in range(30):
        occupied = rng.random((9, 9)) < 0.6
        picture = seen(occupied, (4, 4))
        assert picture[4, [3, 5]].all()
        assert picture[[3, 5], 4].all()
        for row, column in [(3, 3), (3, 5), (5, 3), (5, 5)]:
            assert picture[row, column] != (occupied[row, 4] and occupied[4, column])


def test_the_border_of_the_world_ends_the_view() -> None:
    assert seen(np.zeros((4, 4), dtype=bool), (0, 0)).all()


def test_a_world_turned_around_looks_turned_around() -> None:
    occupied = np.random.default_rng(2).random((21, 21)) < 0.2
    np.testing.assert_array_equal(seen(occupied, (10, 10))[::-1, ::-1], seen(occupied[::-1, ::-1], (10, 10)))


CORNER = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]], dtype=bool)


def test_distances_are_octile_corners_are_gone_around_and_walls_are_never_reached() -> None:
    far = distances_from(np.zeros((4, 6), dtype=bool), (0, 0))
    assert far[[0, 3], [5, 5]] == pytest.approx([5.0, 2.0 + 3.0 * 2.0**0.5])
    np.testing.assert_array_equal(distances_from(CORNER, (0, 1))[[1, 2, 1], [2, 1, 1]], [2.0, 4.0, np.inf])


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
