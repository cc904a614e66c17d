"""Tests of synthetic grid maps."""

import numpy as np
import pytest
from grid_maps import GRID_MAPS, maze, random_field, rooms
from scipy import ndimage

from scene_simulator.errors import SceneError


@pytest.mark.parametrize('kind', GRID_MAPS)
def test_a_seed_makes_one_map_and_another_seed_another(kind: str) -> None:
    make = GRID_MAPS[kind]
    np.testing.assert_array_equal(make(100, 5), make(100, 5))
    assert (make(100, 5) != make(100, 6)).any()


@pytest.mark.parametrize('side', [8, 33, 64, 100])
@pytest.mark.parametrize('kind', GRID_MAPS)
def test_maps_are_enclosed_by_walls_and_hold_free_cells(kind: str, side: int) -> None:
    walls = GRID_MAPS[kind](side, 1)
    assert walls.shape == (side, side)
    assert all(border.all() for border in (walls[0], walls[-1], walls[:, 0], walls[:, -1]))
    assert not walls.all()


@pytest.mark.parametrize('corridor', [1, 2, 5])
def test_all_of_a_maze_can_be_reached_and_without_loops_it_is_a_tree(corridor: int) -> None:
    walls = maze(61, 2, corridor, loop_fraction=0.0)
    assert ndimage.label(~walls)[1] == 1
    count = 60 // (corridor + 1)
    free_in_tree = count**2 * corridor**2 + (count**2 - 1) * corridor
    assert (~walls).sum() == free_in_tree


def test_loops_open_walls_of_a_maze() -> None:
    assert (maze(61, 2, loop_fraction=0.0) & ~maze(61, 2, loop_fraction=0.3)).any()


def test_rooms_without_doors_are_closed() -> None:
    assert ndimage.label(~rooms(65, 1, room=16, closed_fraction=1.0))[1] == 16
    assert ndimage.label(~rooms(65, 1, room=16, closed_fraction=0.0))[1] == 1


def test_a_random_field_has_the_requested_obstacle_fraction() -> None:
    assert random_field(300, 1, 0.3)[1:-1, 1:-1].mean() == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize(
    ('make', 'given', 'words'),
    [
        *((make, (7, 1), '7 x 7') for make in GRID_MAPS.values()),
        (rooms, (64, 1, 16, 15), ''),
        (maze, (64, 1, 0), ''),
        (random_field, (64, 1, 1.0), ''),
        (maze, (64, -1), 'seed'),
    ],
)
def test_a_map_that_cannot_be_is_refused(make, given: tuple[float, ...], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        make(*given)
