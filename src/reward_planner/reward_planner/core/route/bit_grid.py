"""A grid of blocked cells as bits, by rows and by columns, to test 64 cells at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

MARGIN = 64  # bits before the first cell of a line: one 64-bit word of blocked cells

_ALL_BLOCKED = np.uint64(0xFFFFFFFFFFFFFFFF)


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
    lines = np.full((64 * column_words + 2, row_words + 2), _ALL_BLOCKED)
    packed = np.packbits(blocked, axis=1, bitorder='little')
    octets = lines[:, 1:-1].view(np.uint8)[1 : rows + 1]
    octets[:, : packed.shape[1]] = packed
    if columns % 8:
        octets[:, packed.shape[1] - 1] |= np.uint8(0xFF << columns % 8 & 0xFF)
    across = np.full((64 * row_words + 2, column_words + 2), _ALL_BLOCKED)
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
