"""Tests of what a robot sees of a grid world."""

import numpy as np

from scene_simulator.grid_world import GridWorld

REACH = 6.0


def seen(occupied: np.ndarray, cell: tuple[int, int]) -> np.ndarray:
    cells, found = GridWorld(occupied).sense(cell, REACH)
    picture = np.zeros(occupied.shape, dtype=bool)
    picture[tuple(cells.T)] = True
    np.testing.assert_array_equal(found, occupied[tuple(cells.T)])
    return picture


def test_nothing_hides_a_disc_in_the_open() -> None:
    rows, columns = np.indices((30, 30))
    disc = np.hypot(rows - 14, columns - 15) <= REACH
    np.testing.assert_array_equal(seen(np.zeros((30, 30), dtype=bool), (14, 15)), disc)


def test_a_wall_hides_what_is_behind_it_and_is_seen_itself() -> None:
    occupied = np.zeros((30, 30), dtype=bool)
    occupied[:, 18] = True
    picture = seen(occupied, (15, 15))
    assert picture[15, 18]
    assert not picture[:, 19:].any()


def test_all_neighbours_are_seen_whatever_stands_around() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        occupied = rng.random((9, 9)) < 0.6
        assert seen(occupied, (4, 4))[3:6, 3:6].all()


def test_the_border_of_the_world_ends_the_view() -> None:
    assert seen(np.zeros((5, 5), dtype=bool), (0, 0)).all()


def test_a_world_turned_around_looks_turned_around() -> None:
    occupied = np.random.default_rng(2).random((21, 21)) < 0.2
    np.testing.assert_array_equal(seen(occupied, (10, 10))[::-1, ::-1], seen(occupied[::-1, ::-1], (10, 10)))
