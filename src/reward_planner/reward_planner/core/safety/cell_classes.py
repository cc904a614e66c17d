"""Kernels that tell cells at rest from those that moved into space seen free."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.safety.range_kernels import CELL, MOVING, NEVER, STATIC, UNSURE, Cells

_FREE_MEMORY = 2.0  # space that was seen free is known to be free for this long [s]
_MOVER_MEMORY, _MOVER_REACH = 1.0, 12  # a leg at rest moves soon [s]; how near it is to the other [cells]
_STATIC_TIME, _NEAR_MOVER_TIME = 0.4, 1.5  # time at one place until a cell is static [s]
_CONTINUED = 6  # a new cell as near to a static one continues its surface [cells]
_BESIDE = 2  # the same for a cell that was seen free, by rays that graze the surface [cells]
PERSON_TIME = 10.0
"""Who came and stands for less may go; out of view he is expected at his place for as long [s]."""
_TOLERANCE_MAX = 4
_SPAN = 0.02  # tolerance of the heights that were seen free: a scan has one height only [m]


@njit(cache=True)
def classify(cells: Cells, origin: NDArray[np.float64], stamp: float, noise: float) -> None:
    """Classify the cells that are hit now; those that were hit before keep their class."""
    hits = np.argwhere(cells.last == stamp)
    # 1. Cells near none that was occupied before, where rays passed before, moved there.
    for i, j in hits:
        flat = math.hypot(cells.xyz[i, j, 0] - origin[0], cells.xyz[i, j, 1] - origin[1])
        near = min(int(1.0 + 2.0 * noise * flat * flat / CELL), _TOLERANCE_MAX)
        cells.kind[i, j] = UNSURE
        low, z, high = cells.span[i, j, 0] - _SPAN, cells.xyz[i, j, 2], cells.span[i, j, 1] + _SPAN
        if (
            _was_occupied(cells, i, j, near, stamp - _STATIC_TIME)
            or _rested(cells, i, j, near, stamp)
            or _continues_old(cells, i, j, stamp)
        ):
            cells.kind[i, j] = STATIC
        elif stamp - _FREE_MEMORY < cells.free[i, j] < stamp and low < z < high:
            cells.kind[i, j] = MOVING
            cells.moved[i, j] = stamp
    # A single one is noise more often than a part of somebody.
    for i, j in hits:
        if cells.kind[i, j] == MOVING and not _has_company(cells, i, j):
            cells.kind[i, j], cells.moved[i, j] = UNSURE, NEVER
    _settle(cells, hits, stamp)


@njit(cache=True)
def _settle(cells: Cells, hits: NDArray[np.int64], stamp: float) -> None:
    # 2. Near them, a cell is static only after a longer time: a leg at rest is the next to move.
    # 3. What appears beside a static surface is more of it.
    for i, j in hits:
        if cells.kind[i, j] == MOVING:
            continue
        if _moved_since(cells, i, j, stamp - _MOVER_MEMORY):
            is_old = _was_occupied(cells, i, j, 1, stamp - _NEAR_MOVER_TIME)
            cells.kind[i, j] = STATIC if is_old else MOVING
        elif cells.kind[i, j] == UNSURE and _has_static(cells, i, j):
            cells.kind[i, j] = STATIC
    for i, j in hits:
        # Only what is at rest itself, not what touches it: else a slow approach, cell by cell, would be at rest.
        is_old = NEVER < cells.first[i, j] <= stamp - _STATIC_TIME
        if cells.kind[i, j] == STATIC and (is_old or cells.rested[i, j] >= stamp - _FREE_MEMORY):
            cells.rested[i, j] = stamp
    # 4. What is first hit near somebody who moves, or beside what was, is his, until it has been there for long.
    for i, j in hits:
        if cells.first[i, j] == stamp:
            cells.arrived[i, j] = _moved_since(cells, i, j, stamp - _MOVER_MEMORY) or _touches_arrived(cells, i, j)
        elif cells.first[i, j] <= stamp - PERSON_TIME:
            cells.arrived[i, j] = False


@njit(cache=True)
def _continues_old(cells: Cells, i: int, j: int, stamp: float) -> bool:
    """Return whether a cell continues a surface that has been at rest for long and is hit now, too."""
    side = len(cells.key)
    for a in range(-_BESIDE, _BESIDE + 1):
        for b in range(-_BESIDE, _BESIDE + 1):
            k, m = (i + a) % side, (j + b) % side
            if cells.last[k, m] == stamp and NEVER < cells.first[k, m] <= stamp - _STATIC_TIME:
                return True
    return False


@njit(cache=True)
def _rested(cells: Cells, i: int, j: int, near: int, stamp: float) -> bool:
    """Return whether something rested here a moment ago: thin boards and legs are not hit in each measurement."""
    side = len(cells.key)
    for a in range(-near, near + 1):
        for b in range(-near, near + 1):
            if cells.rested[(i + a) % side, (j + b) % side] >= stamp - _FREE_MEMORY:
                return True
    return False


@njit(cache=True)
def _was_occupied(cells: Cells, i: int, j: int, near: int, stamp: float) -> bool:
    side = len(cells.key)
    for a in range(-near, near + 1):
        for b in range(-near, near + 1):
            k, m = (i + a) % side, (j + b) % side
            if NEVER < cells.first[k, m] <= stamp:
                return True
    return False


@njit(cache=True)
def _moved_since(cells: Cells, i: int, j: int, stamp: float) -> bool:
    side = len(cells.key)
    for a in range(-_MOVER_REACH, _MOVER_REACH + 1):
        for b in range(-_MOVER_REACH, _MOVER_REACH + 1):
            if cells.moved[(i + a) % side, (j + b) % side] >= stamp:
                return True
    return False


@njit(cache=True)
def _touches_arrived(cells: Cells, i: int, j: int) -> bool:
    side = len(cells.key)
    for a in range(-_BESIDE, _BESIDE + 1):
        for b in range(-_BESIDE, _BESIDE + 1):
            k, m = (i + a) % side, (j + b) % side
            if cells.arrived[k, m] and cells.last[k, m] >= cells.first[i, j] - _MOVER_MEMORY:
                return True
    return False


@njit(cache=True)
def _has_company(cells: Cells, i: int, j: int) -> bool:
    side, count = len(cells.key), 0
    for a in range(-2, 3):
        for b in range(-2, 3):
            k, m = (i + a) % side, (j + b) % side
            count += cells.kind[k, m] == MOVING and cells.last[k, m] == cells.last[i, j]
    return count > 1


@njit(cache=True)
def _has_static(cells: Cells, i: int, j: int) -> bool:
    side = len(cells.key)
    for a in range(-_CONTINUED, _CONTINUED + 1):
        for b in range(-_CONTINUED, _CONTINUED + 1):
            if cells.kind[(i + a) % side, (j + b) % side] == STATIC:
                return True
    return False
