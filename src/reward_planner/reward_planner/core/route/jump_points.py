"""Jump points of a cell, and the successors of a jump point (Harabor and Grastien, AAAI 2011, ICAPS 2014).

Of all shortest paths between two cells only one is followed: diagonal steps first, then straight ones. So the search
turns from straight to diagonal only where an adjacent wall ends. On a diagonal, only the jump points along its rows
and columns are kept.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

MARGIN = 64  # bits before the first cell of a line: one 64-bit word of blocked cells

_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
_ONE = np.uint64(1)
_LAST = np.uint64(63)
_SIX = np.uint64(58)
_DE_BRUIJN = np.uint64(0x03F79D71B4CB0A89)  # de Bruijn sequence: every run of six bits occurs once


def _bit_indices() -> NDArray[np.int64]:
    places = np.empty(64, dtype=np.int64)
    for bit in range(64):
        places[(int(_DE_BRUIJN) << bit & int(_ALL)) >> 58] = bit
    return places


_BIT_INDICES = _bit_indices()


class BitGrid(NamedTuple):
    """A grid with bit 1 for blocked cells and a border of one blocked line and one blocked word.

    Attributes:
        rows: rows as bits, cell (r, c) is bit MARGIN + c of line r + 1; uint64, shape (rows + 2, words).
        columns: columns as bits, cell (r, c) is bit MARGIN + r of line c + 1; uint64, shape (columns + 2, words).
    """

    rows: NDArray[np.uint64]
    columns: NDArray[np.uint64]


def pack_grid(blocked: NDArray[np.bool_]) -> BitGrid:
    """Pack a grid of shape (rows, columns) into bits."""
    rows, columns = blocked.shape
    row_words, column_words = -(-columns // 64), -(-rows // 64)
    lines = np.full((64 * column_words + 2, row_words + 2), _ALL)
    packed = np.packbits(blocked, axis=1, bitorder='little')
    octets = lines[:, 1:-1].view(np.uint8)[1 : rows + 1]
    octets[:, : packed.shape[1]] = packed
    if columns % 8:
        octets[:, packed.shape[1] - 1] |= np.uint8(0xFF << columns % 8 & 0xFF)
    across = np.full((64 * row_words + 2, column_words + 2), _ALL)
    _transpose(lines, across)
    return BitGrid(lines[: rows + 2], across[: columns + 2])


@njit(cache=True)
def _transpose(lines: NDArray[np.uint64], across: NDArray[np.uint64]) -> None:
    """Transpose a bit matrix in blocks of 64 x 64 bits."""
    block = np.empty(64, np.uint64)
    for i in range(across.shape[1] - 2):
        for j in range(lines.shape[1] - 2):
            for k in range(64):
                block[k] = lines[64 * i + k + 1, j + 1]
            _transpose_block(block)
            for k in range(64):
                across[64 * j + k + 1, i + 1] = block[k]


@njit(cache=True)
def _transpose_block(block: NDArray[np.uint64]) -> None:
    """Transpose a block of 64 x 64 bits (Hacker's Delight, 7-3)."""
    width = 32
    mask = np.uint64(0x00000000FFFFFFFF)
    while width:
        shift = np.uint64(width)
        k = 0
        while k < 64:
            swapped = ((block[k] >> shift) ^ block[k + width]) & mask
            block[k] ^= swapped << shift
            block[k + width] ^= swapped
            k = (k + width + 1) & ~width
        width >>= 1
        mask ^= mask << np.uint64(width)


@njit(cache=True)
def _bit_index(bit: np.uint64) -> int:
    """Return the index of the only bit that is set."""
    return _BIT_INDICES[(bit * _DE_BRUIJN) >> _SIX]


@njit(cache=True)
def scan_up(lines: NDArray[np.uint64], line: int, begin: int, goal: int) -> int:
    """Return where a scan towards higher positions on a line, rows or columns of a `BitGrid`, stops.

    It begins at a free cell; the goal is a position on this line, 0 if it is on another one.

    Returns:
        first position after the end of an adjacent wall, or the goal; 0 if the line is blocked before.
    """
    word = begin >> 6
    mask = (_ALL << np.uint64(begin & 63)) << _ONE
    while True:
        below, above = lines[line - 1, word], lines[line + 1, word]
        ended = ~below & ((below << _ONE) | (lines[line - 1, word - 1] >> _LAST))
        ended |= ~above & ((above << _ONE) | (lines[line + 1, word - 1] >> _LAST))
        stops = (lines[line, word] | ended) & mask
        if stops:
            break
        word += 1
        mask = _ALL
    bit = stops & (~stops + _ONE)
    place = (word << 6) + _bit_index(bit)
    if begin < goal < place:
        return goal
    return 0 if lines[line, word] & bit else place


@njit(cache=True)
def scan_down(lines: NDArray[np.uint64], line: int, begin: int, goal: int) -> int:
    """Return where a scan towards lower positions stops; arguments and result as for `scan_up`."""
    word = begin >> 6
    mask = (_ONE << np.uint64(begin & 63)) - _ONE
    while True:
        below, above = lines[line - 1, word], lines[line + 1, word]
        ended = ~below & ((below >> _ONE) | (lines[line - 1, word + 1] << _LAST))
        ended |= ~above & ((above >> _ONE) | (lines[line + 1, word + 1] << _LAST))
        stops = (lines[line, word] | ended) & mask
        if stops:
            break
        word -= 1
        mask = _ALL
    bit = _highest_bit(stops)
    place = (word << 6) + _bit_index(bit)
    if place < goal < begin:
        return goal
    return 0 if lines[line, word] & bit else place


@njit(cache=True)
def _highest_bit(bits: np.uint64) -> np.uint64:
    """Return a word with only the highest set bit."""
    bits |= bits >> np.uint64(1)
    bits |= bits >> np.uint64(2)
    bits |= bits >> np.uint64(4)
    bits |= bits >> np.uint64(8)
    bits |= bits >> np.uint64(16)
    bits |= bits >> np.uint64(32)
    return bits ^ (bits >> _ONE)


@njit(cache=True)
def is_blocked(grid: BitGrid, row: int, column: int) -> bool:
    """Return whether a cell is blocked; the border is."""
    place = column + MARGIN
    return (grid.rows[row + 1, place >> 6] >> np.uint64(place & 63)) & np.uint64(1) != np.uint64(0)


@njit(cache=True)
def jump_along_row(grid: BitGrid, row: int, column: int, direction: int, goal_row: int, goal_column: int) -> int:
    """Return the column of the jump point in this row, towards higher (1) or lower columns (-1); -1 if none."""
    goal = goal_column + MARGIN if goal_row == row else 0
    if direction > 0:
        place = scan_up(grid.rows, row + 1, column + MARGIN, goal)
    else:
        place = scan_down(grid.rows, row + 1, column + MARGIN, goal)
    return place - MARGIN if place else -1


@njit(cache=True)
def jump_along_column(grid: BitGrid, row: int, column: int, direction: int, goal_row: int, goal_column: int) -> int:
    """Return the row of the jump point in this column, towards higher (1) or lower rows (-1); -1 if none."""
    goal = goal_row + MARGIN if goal_column == column else 0
    if direction > 0:
        place = scan_up(grid.columns, column + 1, row + MARGIN, goal)
    else:
        place = scan_down(grid.columns, column + 1, row + MARGIN, goal)
    return place - MARGIN if place else -1


@njit(cache=True)
def jump_diagonally(
    grid: BitGrid,
    row: int,
    column: int,
    directions: tuple[int, int],
    goal: tuple[int, int],
    found: NDArray[np.int32],
    count: int,
) -> int:
    """Append the jump points along the rows and columns of a diagonal.

    The diagonal starts at a cell in the directions 1 or -1 of rows and of columns. ``found`` is the output: rows and
    columns of jump points, shape (n, 2), with ``count`` entries so far; return the new count.
    """
    row_direction, column_direction = directions
    while not (
        is_blocked(grid, row + row_direction, column)
        or is_blocked(grid, row, column + column_direction)
        or is_blocked(grid, row + row_direction, column + column_direction)
    ):
        row += row_direction
        column += column_direction
        if row == goal[0] and column == goal[1]:
            found[count, 0], found[count, 1] = row, column
            return count + 1
        place = jump_along_row(grid, row, column, column_direction, goal[0], goal[1])
        if place >= 0:
            found[count, 0], found[count, 1] = row, place
            count += 1
        place = jump_along_column(grid, row, column, row_direction, goal[0], goal[1])
        if place >= 0:
            found[count, 0], found[count, 1] = place, column
            count += 1
    return count


@njit(cache=True)
def add_straight_jump_point(
    grid: BitGrid,
    row: int,
    column: int,
    directions: tuple[int, int],
    goal: tuple[int, int],
    found: NDArray[np.int32],
    count: int,
) -> int:
    """Append the jump point straight ahead; arguments and result as for `jump_diagonally`, one direction is 0."""
    if directions[0]:
        place = jump_along_column(grid, row, column, directions[0], goal[0], goal[1])
        found[count, 0], found[count, 1] = place, column
    else:
        place = jump_along_row(grid, row, column, directions[1], goal[0], goal[1])
        found[count, 0], found[count, 1] = row, place
    return count + 1 if place >= 0 else count


@njit(cache=True)
def successors_of_start(grid: BitGrid, row: int, column: int, goal: tuple[int, int], found: NDArray[np.int32]) -> int:
    """Find the jump points in all eight directions; return their number."""
    count = 0
    for direction in (-1, 1):
        count = add_straight_jump_point(grid, row, column, (direction, 0), goal, found, count)
        count = add_straight_jump_point(grid, row, column, (0, direction), goal, found, count)
        count = jump_diagonally(grid, row, column, (direction, -1), goal, found, count)
        count = jump_diagonally(grid, row, column, (direction, 1), goal, found, count)
    return count


@njit(cache=True)
def successors(
    grid: BitGrid, row: int, column: int, parent: tuple[int, int], goal: tuple[int, int], found: NDArray[np.int32]
) -> int:
    """Find the jump points that follow a jump point; arguments as for `jump_diagonally`, return their number.

    The path from the ``parent``, the previous jump point, ends with straight steps.
    """
    rows, columns = row - parent[0], column - parent[1]
    along_row = abs(columns) > abs(rows)
    ahead = (0, 1 if columns > 0 else -1) if along_row else (1 if rows > 0 else -1, 0)
    count = add_straight_jump_point(grid, row, column, ahead, goal, found, 0)
    for direction in (-1, 1):
        side = (direction, 0) if along_row else (0, direction)
        # The adjacent wall ends here, so the cells behind it are reached through this cell only.
        if is_blocked(grid, row + side[0] - ahead[0], column + side[1] - ahead[1]) and not is_blocked(
            grid, row + side[0], column + side[1]
        ):
            count = add_straight_jump_point(grid, row, column, side, goal, found, count)
            diagonal = (ahead[0] + side[0], ahead[1] + side[1])
            count = jump_diagonally(grid, row, column, diagonal, goal, found, count)
    return count
