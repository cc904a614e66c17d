"""Lengths of routes on known maps, compared with MovingAI's scenario file and a second implementation.

MovingAI's arena with all pairs of its scenario file (``SHIRUBE_DATA`` names the folder with planner/arena.map), and
made-up maps with scipy's Dijkstra as the truth. Every route is checked: neighbouring free cells, no corner cut.
"""

from __future__ import annotations

import argparse

import numpy as np
from _grid_tasks import GridTask, arena_file, benchmark_maps, solvable_tasks, unsolvable_tasks
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route
from scene_simulator.room.grid_world import is_traversable
from scene_simulator.room.movingai_files import load_movingai_scenarios

ALLOWED = 1e-3


def errors_of(
    routes: list[Route | NoRoute], tasks: list[GridTask], blocked: NDArray[np.bool_]
) -> list[float]:
    """Return how much longer or shorter than the truth each route is [cells]; infinite where it cannot be driven."""
    errors = []
    for route, task in zip(routes, tasks, strict=True):
        good = isinstance(route, Route) and is_traversable(blocked, route.cells)
        errors.append(abs(route.length - task.length) if isinstance(route, Route) and good else np.inf)
    return errors


def print_map(name: str, truth: str, blocked: NDArray[np.bool_], tasks: list[GridTask], lost: int) -> bool:
    """Print a line; return whether all is as it must be."""
    astar = errors_of([shortest_route(blocked, t.start, t.goal) for t in tasks], tasks, blocked)
    dstar_lite = errors_of([DStarLite(blocked, t.goal).route_from(t.start) for t in tasks], tasks, blocked)
    unsolvable = unsolvable_tasks(blocked, lost, 3)
    no_route_count = sum(isinstance(shortest_route(blocked, t.start, t.goal), NoRoute) for t in unsolvable)
    equal = sum(max(pair) <= ALLOWED for pair in zip(astar, dstar_lite, strict=True))
    rows, columns = blocked.shape
    print(
        f'| {name} | {columns}x{rows} | {truth} | {equal} of {len(tasks)} | {max(astar):.1e} | {max(dstar_lite):.1e} '
        f'| {no_route_count} of {len(unsolvable)} |'
    )
    return equal == len(tasks) and no_route_count == len(unsolvable)


def main() -> int:
    """Run the benchmark; return 1 when a length is wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--side', type=int, default=256, help='of the made-up maps [cells]')
    parser.add_argument('--seeds', type=int, default=3, help='made-up maps of each kind')
    parser.add_argument('--pairs', type=int, default=200, help='start and goal, of each made-up map')
    arguments = parser.parse_args()
    maps = benchmark_maps(arguments.side, arguments.seeds)
    print(
        '\n| map | cells | truth | equal to 1e-3 | greatest difference: A* | D* Lite | unreachable goals reported |'
    )
    print('|---|---|---|---|---|---|---|')
    scenarios = load_movingai_scenarios(arena_file().with_suffix('.map.scen'))
    tasks = [GridTask(s.start, s.goal, s.length) for s in scenarios]
    good = print_map('arena', 'scenario file', maps.pop('arena'), tasks, 50)
    for name, blocked in tqdm(maps.items(), leave=False):
        tasks = solvable_tasks(blocked, arguments.pairs, 4, goals=10)
        good &= print_map(name, 'Dijkstra', blocked, tasks, 50)
    return 0 if good else 1


if __name__ == '__main__':
    raise SystemExit(main())
