"""Maps and pairs of start and goal for the benchmarks of planners."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from scene_simulator.room.grid_maps import GRID_MAPS
from scene_simulator.room.grid_world import distances_from, step_graph
from scene_simulator.room.movingai_files import load_movingai_map


class GridTask(NamedTuple):
    """One start and goal.

    Attributes:
        start: row and column.
        goal: row and column.
        length: length of the shortest route, by Dijkstra; infinite where there is none [cells].
    """

    start: tuple[int, int]
    goal: tuple[int, int]
    length: float


def arena_file() -> Path:
    """Return MovingAI's map `arena`, or end with a line that says where it must be."""
    path = Path(os.environ.get('SHIRUBE_DATA', 'not given')) / 'planner' / 'arena.map'
    if not path.is_file():
        sys.exit('SHIRUBE_DATA: set it to the folder that holds planner/arena.map and planner/arena.map.scen')
    return path


def benchmark_maps(side: int, seeds: int) -> dict[str, NDArray[np.bool_]]:
    """Return MovingAI's arena and made-up maps of every kind, by name."""
    maps = {'arena': load_movingai_map(arena_file())}
    for kind, make in GRID_MAPS.items():
        maps |= {f'{kind} {seed}': make(side, seed) for seed in range(1, seeds + 1)}
    return maps


def solvable_tasks(blocked: NDArray[np.bool_], count: int, seed: int, goals: int = 1) -> list[GridTask]:
    """Return pairs of free cells with a route between them, so many goals for each start."""
    rng = np.random.default_rng(seed)
    graph, free = step_graph(blocked), np.argwhere(~blocked)
    tasks: list[GridTask] = []
    while len(tasks) < count:
        start = _cell(rng.choice(free))
        distances = distances_from(blocked, start, graph)
        near = np.argwhere(np.isfinite(distances) & (distances > 0.0))
        if len(near):
            chosen = [_cell(goal) for goal in rng.choice(near, goals)]
            tasks += [GridTask(start, goal, float(distances[goal])) for goal in chosen]
    return tasks[:count]


def unsolvable_tasks(blocked: NDArray[np.bool_], count: int, seed: int) -> list[GridTask]:
    """Return pairs of free cells without a route; a map without any gives none."""
    rng = np.random.default_rng(seed)
    parts, number = ndimage.label(~blocked)
    free = np.argwhere(~blocked)
    tasks: list[GridTask] = []
    while number > 1 and len(tasks) < count:
        start, goal = (_cell(cell) for cell in rng.choice(free, 2))
        if parts[start] != parts[goal]:
            tasks.append(GridTask(start, goal, np.inf))
    return tasks


def _cell(cell: NDArray[np.int64]) -> tuple[int, int]:
    return int(cell[0]), int(cell[1])
