"""Files of routes."""

from pathlib import Path

import numpy as np

from reward_planner.commands.plan import draw_route, save_route_table
from reward_planner.core.occupancy_map import GridFrame, OccupancyMap


def test_every_kind_of_cell_has_its_colour_and_the_highest_row_is_above() -> None:
    occupancy = np.array([[0, 100], [-1, 0]], dtype=np.int8)
    blocked = np.array([[False, True], [False, True]])
    grid = OccupancyMap(GridFrame(0.0, 0.0, 1.0, 2, 2), occupancy)
    picture = draw_route(grid, blocked, np.empty((0, 2), dtype=np.int64))
    half = len(picture) // 2
    assert picture.shape == (800, 800, 3)
    for rows, columns, colour in (
        (np.s_[half:], np.s_[:half], (255, 255, 255)),
        (np.s_[half:], np.s_[half:], (0, 0, 0)),
        (np.s_[:half], np.s_[:half], (205, 205, 205)),
        (np.s_[:half], np.s_[half:], (200, 215, 250)),
    ):
        assert (picture[rows, columns] == colour).all()


def test_the_route_begins_green_and_ends_red() -> None:
    grid = OccupancyMap(GridFrame(0.0, 0.0, 1.0, 40, 20), np.zeros((20, 40), dtype=np.int8))
    cells = np.stack([np.full(30, 4), np.arange(5, 35)], axis=1)
    picture = draw_route(grid, np.zeros((20, 40), dtype=bool), cells)
    row = picture[(19 - 4) * 20 + 10]
    assert row[5 * 20 + 10].tolist() == [0, 150, 0]
    assert row[34 * 20 + 10].tolist() == [0, 0, 220]
    assert row[20 * 20].tolist() == [200, 60, 0]


def test_a_table_has_a_header_and_a_line_a_point_in_metres(tmp_path: Path) -> None:
    save_route_table(tmp_path / 'new' / 'route.csv', np.array([[0.025, -1.0], [0.075, -0.95]]))
    assert (tmp_path / 'new' / 'route.csv').read_text() == 'x,y\n0.0250,-1.0000\n0.0750,-0.9500\n'
