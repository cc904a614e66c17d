"""Drives through unknown terrain: how often the goal is reached, and how much longer than the shortest route.

MovingAI's arena (SHIRUBE_DATA, ``planner/arena.map``) and made-up maps as large as it. A robot sees 6 cells far in line
of sight and takes what it does not know for free. After 20 times the shortest route a drive has failed.
"""

from typing import NamedTuple

import numpy as np
from _figures import error, mean, rate
from _harness import MissingError, Option, Run, progress, run_benchmark, use_one_core
from grid_maps import GRID_MAPS
from grid_world import GridWorld, distances_from, is_traversable, step_graph
from movingai_files import load_movingai_map
from numpy.typing import NDArray
from scipy import ndimage

from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import NoRoute, route_length
from reward_planner.core.settings import RewardSettings, RewardTable

SENSOR_RANGE = 6.0
GIVE_UP = 20.0
PLANNED_MAX = 1000
Cell = tuple[int, int]


class GridTask(NamedTuple):
    """Start and goal, row and column, and the length of the shortest route, by Dijkstra; infinite for none [cells]."""

    start: Cell
    goal: Cell
    length: float


class Drive(NamedTuple):
    """How a drive ended, at the 'goal', 'unreachable' (the robot says so) or 'too long', and its length [cells]."""

    ended: str
    length: float


def terrain_maps(run: Run, side: int, seeds: int) -> dict[str, NDArray[np.bool_]]:
    """Return MovingAI's arena, where it is, and made-up maps of every kind, by name."""
    maps = {}
    try:
        maps['arena'] = load_movingai_map(run.data('planner', 'arena.map'))
    except MissingError as missing:
        run.note(f'Without the arena: {missing}')
    for kind, make in GRID_MAPS.items():
        maps |= {f'{kind} {seed}': make(side, seed) for seed in range(1, seeds + 1)}
    return maps


def solvable_tasks(blocked: NDArray[np.bool_], count: int) -> list[GridTask]:
    """Return pairs of free cells with a route between them."""
    rng, graph, free = np.random.default_rng(1), step_graph(blocked), np.argwhere(~blocked)
    tasks: list[GridTask] = []
    while len(tasks) < count:
        start = _cell(rng.choice(free))
        distances = distances_from(blocked, start, graph)
        near = np.argwhere(np.isfinite(distances) & (distances > 0.0))
        if len(near):
            goal = _cell(rng.choice(near))
            tasks.append(GridTask(start, goal, float(distances[goal])))
    return tasks


def unsolvable_tasks(blocked: NDArray[np.bool_], count: int) -> list[GridTask]:
    """Return pairs of free cells without a route; a map without any gives none."""
    rng, free = np.random.default_rng(2), np.argwhere(~blocked)
    parts, number = ndimage.label(~blocked)
    tasks: list[GridTask] = []
    while number > 1 and len(tasks) < count:
        start, goal = (_cell(cell) for cell in rng.choice(free, 2))
        if parts[start] != parts[goal]:
            tasks.append(GridTask(start, goal, np.inf))
    return tasks


def _cell(cell: NDArray[np.int64]) -> Cell:
    return int(cell[0]), int(cell[1])


def drive(blocked: NDArray[np.bool_], task: GridTask, length_max: float, settings: RewardSettings | None) -> Drive:
    """Drive on the map known so far: by rewards, or along the shortest route, which is replanned for new obstacles.

    Rewards do not tell whether the goal can be reached at all; the shortest route does.
    """
    world, cells, length = GridWorld(blocked), [task.start], 0.0
    routes, ended = DStarLite(np.zeros_like(blocked), task.goal), 'goal'
    walk = None if settings is None else RewardWalk(blocked.shape, task.start, task.goal, settings)
    while cells[-1] != task.goal:
        if length > length_max:
            ended = 'too long'
            break
        routes.update_cells(*world.observe(cells[-1], SENSOR_RANGE))
        route = routes.route_from(cells[-1])
        if isinstance(route, NoRoute) or not (walk is None or walk.advance(routes.blocked)):
            ended = 'unreachable'
            break
        cells.append(_cell(route.cells[1]) if walk is None else walk.cell)
        length += float(np.hypot(*np.subtract(cells[-1], cells[-2])))
    way = np.array(cells, dtype=np.int64)
    if not is_traversable(blocked, way):
        raise AssertionError('the robot drove into an obstacle')
    return Drive(ended, route_length(way))


METHODS: dict[str, RewardSettings | None] = {
    '`optimal`': None,
    '`reward`, visits once (the paper)': RewardSettings('once', PLANNED_MAX),
    '`reward`, visits counted': RewardSettings('counted', PLANNED_MAX),
    'visits once, no virtual search': RewardSettings('once', 0),
    'visits counted, no virtual search': RewardSettings('counted', 0),
    'visits once, without row 5': RewardSettings('once', PLANNED_MAX, RewardTable(detour=0.0)),
}
DETECTING = ('`optimal`', '`reward`, visits counted')


def main(run: Run, side: int, seeds: int, pairs: int, only: str) -> None:
    """Drive on all maps with all methods."""
    use_one_core()
    maps = terrain_maps(run, side, seeds)
    tasks = {name: solvable_tasks(blocked, pairs) for name, blocked in maps.items()}
    methods = {name: settings for name, settings in METHODS.items() if only in name}
    by_map = run.table('Goals reached on each map', 'map', *methods)
    ratios: dict[str, list[float]] = {method: [] for method in methods}
    for name, blocked in progress(maps.items(), 'maps', len(maps)):
        cells = []
        for method, settings in methods.items():
            done = [(drive(blocked, task, GIVE_UP * task.length, settings), task) for task in tasks[name]]
            reached = [found.length / task.length for found, task in done if found.ended == 'goal']
            cells.append(rate(len(reached), len(done)))
            ratios[method] += reached
        by_map.add(name, *cells)
    table = run.table('Unknown terrain', 'method | goal reached | length / shortest: median / 95 % / max | mean')
    for method, lengths in ratios.items():
        table.add(method, rate(len(lengths), pairs * len(maps)), error(lengths, '.2f'), mean(lengths))
    few = max(pairs // 8, 1)
    lost = [(blocked, task) for blocked in maps.values() for task in unsolvable_tasks(blocked, few)]
    heads = 'method | detected | length driven until then, cells: median / 95 %'
    table = run.table('Unreachable goals', heads)
    for method in DETECTING:
        drives = [drive(blocked, task, 1e5, METHODS[method]) for blocked, task in progress(lost, method)]
        lengths = [found.length for found in drives if found.ended == 'unreachable']
        table.add(method, rate(len(lengths), len(lost)), error(lengths, '.0f', shown=(50, 95)))


if __name__ == '__main__':
    run_benchmark(
        main,
        side=Option(49, 49, 'of the made-up maps [cells]'),
        seeds=Option(2, 1, 'made-up maps of each kind'),
        pairs=Option(150, 5, 'start and goal, of each map'),
        only=Option('', '', 'methods whose name holds this'),
    )
