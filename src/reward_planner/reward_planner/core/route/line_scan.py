"""Line scans of jump point search, 64 cells at once.

A scan along a row or column stops where an adjacent wall ends: there cells become reachable that a diagonal step could
not reach before, because corners are not cut.
See Harabor and Grastien, "Improving Jump Point Search", ICAPS 2014, with the corner rule of this suite.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

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


@njit(cache=True)
def _bit_index(bit: np.uint64) -> int:
    """Return the index of the only bit that is set."""
    return _BIT_INDICES[(bit * _DE_BRUIJN) >> _SIX]


@njit(cache=True)
def scan_up(lines: NDArray[np.uint64], line: int, begin: int, goal: int) -> int:
    """Return where a scan towards higher positions on a line stops.

    Args:
        lines: rows or columns of a `BitGrid`, shape (lines, words).
        line: index of the line.
        begin: start position on the line, a free cell.
        goal: position of the goal on this line; 0 if it is on another one.

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
