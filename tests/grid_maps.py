"""Synthetic grid maps for planners: rooms, mazes, warehouses, random fields. True is a wall."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from scene_simulator.errors import SceneError, check_seed

_MIN_SIDE = 8  # smallest map side [cells]
_STEPS = ((-1, 0), (1, 0), (0, -1), (0, 1))


def rooms(side: int, seed: int, room: int = 16, door: int = 2, closed_fraction: float = 0.2) -> NDArray[np.bool_]:
    """Return square rooms in rows, walls one cell thick, a door somewhere in most walls; lengths in cells.

    Raises:
        SceneError: the map is too small, the rooms do not hold their doors, or the seed is negative.
    """
    _check(side, seed)
    if not 1 <= door <= room - 2:
        raise SceneError(f'doors of {door} cells in rooms of {room}: give 1 to {room - 2}')
    rng = np.random.default_rng(seed)
    walls = np.zeros((side, side), dtype=bool)
    walls[::room], walls[:, ::room] = True, True
    for along in (walls, walls.T):
        for wall in range(room, side, room):
            for begin in range(0, side, room):
                if rng.random() >= closed_fraction:
                    place = begin + 1 + rng.integers(room - door)
                    along[wall, place : place + door] = False
    return _add_border(walls)


def maze(side: int, seed: int, corridor: int = 3, loop_fraction: float = 0.05) -> NDArray[np.bool_]:
    """Return a maze of corridors between walls one cell thick: a random spanning tree with some walls removed.

    Raises:
        SceneError: the map is too small, there are no corridors, or the seed is negative.
    """
    _check(side, seed)
    if corridor < 1:
        raise SceneError(f'corridors of {corridor} cells: give 1 or more')
    rng = np.random.default_rng(seed)
    pitch = corridor + 1
    count = (side - 1) // pitch
    walls = np.ones((side, side), dtype=bool)
    visited = np.zeros((count, count), dtype=bool)
    trail = [(int(rng.integers(count)), int(rng.integers(count)))]
    visited[trail[0]] = True
    _open_passage(walls, trail[0], trail[0], pitch)
    while trail:
        row, column = trail[-1]
        steps = [s for s in _STEPS if _is_unvisited(visited, row + s[0], column + s[1])]
        if not steps:
            trail.pop()
            continue
        rows, columns = steps[rng.integers(len(steps))]
        trail.append((row + rows, column + columns))
        visited[trail[-1]] = True
        _open_passage(walls, (row, column), trail[-1], pitch)
    for row, column in np.argwhere(rng.random((count - 1, count - 1)) < loop_fraction).tolist():
        _open_passage(walls, (row, column), (row + 1, column) if rng.random() < 0.5 else (row, column + 1), pitch)
    return walls


def warehouse(side: int, seed: int, pallet_density: float = 0.01) -> NDArray[np.bool_]:
    """Return a hall of long shelves with aisles between them, some shelves shorter, and pallets left in the aisles.

    The density of the pallets of 2 x 2 cells is a fraction of all cells over four.
    """
    _check(side, seed)
    rng = np.random.default_rng(seed)
    walls = np.zeros((side, side), dtype=bool)
    for row in range(6, side - 6, 8):
        for column in range(6, side - 6, 30):
            end = min(column + int(rng.integers(16, 27)), side - 6)
            walls[row : row + 3, column + int(rng.integers(4)) : end] = True
    corners = rng.integers(1, side - 2, (round(pallet_density * side * side / 4), 2))
    for row, column in corners.tolist():
        walls[row : row + 2, column : column + 2] = True
    return _add_border(walls)


def random_field(side: int, seed: int, fraction: float = 0.2) -> NDArray[np.bool_]:
    """Return a field in which each cell is an obstacle with the same probability."""
    _check(side, seed)
    if not 0.0 <= fraction < 1.0:
        raise SceneError(f'the obstacle probability is {fraction}: give 0 or more and less than 1')
    return _add_border(np.random.default_rng(seed).random((side, side)) < fraction)


GRID_MAPS: dict[str, Callable[[int, int], NDArray[np.bool_]]] = {
    'rooms': rooms,
    'maze': maze,
    'warehouse': warehouse,
    'random field': random_field,
}


def _check(side: int, seed: int) -> None:
    if side < _MIN_SIDE:
        raise SceneError(f'a map of {side} x {side} cells: give {_MIN_SIDE} or more')
    check_seed(seed)


def _add_border(walls: NDArray[np.bool_]) -> NDArray[np.bool_]:
    walls[[0, -1]] = True
    walls[:, [0, -1]] = True
    return walls


def _is_unvisited(visited: NDArray[np.bool_], row: int, column: int) -> bool:
    count = len(visited)
    return 0 <= row < count and 0 <= column < count and not visited[row, column]


def _open_passage(walls: NDArray[np.bool_], cell: tuple[int, int], other: tuple[int, int], pitch: int) -> None:
    """Remove the walls in and between two adjacent squares of a maze."""
    low, high = np.minimum(cell, other) * pitch + 1, np.maximum(cell, other) * pitch + pitch
    walls[low[0] : high[0], low[1] : high[1]] = False
