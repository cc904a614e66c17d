"""A grid of blocked cells as bits, by rows and by columns, and its line scans of 64 cells at once.

A scan along a row or column stops where an adjacent wall ends: there cells become reachable that a diagonal step could
not reach before, because corners are not cut.
See Harabor and Grastien, "Improving Jump Point Search", ICAPS 2014, with the corner rule of this suite.
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
