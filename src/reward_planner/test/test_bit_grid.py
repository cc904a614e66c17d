"""Bit grids and their line scans."""

import numpy as np
import pytest

from reward_planner.core.route.jump_points import MARGIN, pack_grid, scan_down, scan_up


def bits_of(lines: np.ndarray) -> np.ndarray:
    return np.unpackbits(lines.view(np.uint8), axis=1, bitorder='little').astype(bool)


@pytest.mark.parametrize('shape', [(1, 1), (5, 64), (64, 128), (65, 63), (130, 7), (100, 200)])
def test_bits_are_the_cells_and_all_around_is_blocked(shape: tuple[int, int]) -> None:
    blocked = np.random.default_rng(1).random(shape) < 0.5
    grid = pack_grid(blocked)
    for lines, cells in ((grid.rows, blocked), (grid.columns, blocked.T)):
        bits = bits_of(lines)
        rows, columns = cells.shape
        inside = np.s_[1 : rows + 1, MARGIN : MARGIN + columns]
        np.testing.assert_array_equal(bits[inside], cells)
        bits[inside] = True
        assert bits.all()
        assert len(lines) == rows + 2


def walk(blocked: np.ndarray, row: int, begin: int, step: int, goal: int) -> int:
    around = np.pad(blocked, 1, constant_values=True)
    column = begin + step
    while not around[row + 1, column + 1]:
        ended = [around[r, column + 1 - step] and not around[r, column + 1] for r in (row, row + 2)]
        if any(ended) or column == goal:
            return column + MARGIN
        column += step
    return 0


@pytest.mark.parametrize('share', [0.01, 0.05, 0.3])
def test_scans_stop_where_a_walk_does(share: float) -> None:
    rng = np.random.default_rng(2)
    blocked = rng.random((20, 300)) < share
    grid = pack_grid(blocked)
    for row, column in np.argwhere(~blocked).tolist():
        goal = int(rng.integers(300))
        if blocked[row, goal] or goal == column:
            goal = -MARGIN
        arguments = (grid.rows, row + 1, column + MARGIN, goal + MARGIN)
        assert scan_up(*arguments) == walk(blocked, row, column, 1, goal)
        assert scan_down(*arguments) == walk(blocked, row, column, -1, goal)
