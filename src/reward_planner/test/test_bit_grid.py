"""Tests of grids as bits."""

import numpy as np
import pytest

from reward_planner.core.route.bit_grid import MARGIN, pack_grid


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
