"""Time of plans on maps of 1024x1024 cells: from scratch against nano-astar, and replanning against from scratch.

Known maps: all methods find the same lengths by the same corner rule; they take turns on the same pairs, warm. The time
of ours holds all it does, from the array of the map to the route. Unknown maps: a robot that sees 6 cells far follows
its plan; at every step where it sees a new obstacle, the plan is repaired, and at every tenth also made from scratch.
Costs: maps of larger structures, 5 cm a cell, with the node's defaults. The gap is the least distance of a route from
obstacles minus the least one that is allowed.
"""

from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np
from _figures import error, ratio, time
from _harness import Option, Run, cpu_time, progress, run_benchmark, use_one_core
from grid_maps import GRID_MAPS, maze, random_field, rooms
from grid_world import GridWorld
from numpy.typing import NDArray

from reward_planner.core.driving.replanner import MARGIN_CELLS_MIN
from reward_planner.core.occupancy_map import clearance
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import COST_MAX, NoRoute, Route, inflation_costs
from reward_planner.core.route.shortest_route import shortest_route
from reward_planner.core.settings import DrivingSettings, PlannerSettings

SENSOR_RANGE = 6.0
STEPS_MAX = 1500
EVERY = 10
COARSE = 16  # cells a side of a block of a map with costs
RESOLUTION = 0.05
Cell = tuple[int, int]


Times = defaultdict[str, list[float]]
"""Times of one map [ms]: of replans, of those whose new obstacle was on the route, and of searches from scratch."""


def speed_maps(side: int) -> dict[str, NDArray[np.bool_]]:
    """Return maps of many kinds by name."""
    maps = {kind: make(side, 1) for kind, make in GRID_MAPS.items()}
    maps |= {f'random field, {100 * share:.0f} %': random_field(side, 2, share) for share in (0.1, 0.3, 0.35)}
    maps['rooms of 32'] = rooms(side, 1, 32)
    maps['maze of 1, no loops'] = maze(side, 1, 1, 0.0)
    maps['empty'] = np.zeros((side, side), dtype=bool)
    return maps


def pairs_of(blocked: NDArray[np.bool_], count: int) -> list[tuple[Cell, Cell]]:
    """Return pairs of free cells with a route between them."""
    rng, free = np.random.default_rng(5), np.argwhere(~blocked)
    pairs: list[tuple[Cell, Cell]] = []
    while len(pairs) < count:
        (a, b), (c, d) = rng.choice(free, 2).tolist()
        if isinstance(shortest_route(blocked, (a, b), (c, d)), Route):
            pairs.append(((a, b), (c, d)))
    return pairs


def route_of(answer: Route | NoRoute) -> Route:
    """Return a route that must be there."""
    if isinstance(answer, NoRoute):
        raise TypeError(answer.value)
    return answer


def check_lengths(one: float, other: float) -> None:
    """See that two routes are equally long."""
    if abs(one - other) > 1e-6:
        raise AssertionError(f'lengths {one} and {other}')


def compare(blocked: NDArray[np.bool_], count: int, peer: Callable[..., Any]) -> NDArray[np.float64]:
    """Return the times of ours and of the peer's plans, shape (count, 2) [ms]."""
    octets = np.ascontiguousarray(blocked).view(np.uint8)
    methods = (lambda ends: route_of(shortest_route(blocked, *ends)).length, lambda ends: peer(octets, *ends)[1])
    times = []
    for number, pair in enumerate(pairs_of(blocked, count)):
        answers = {k: cpu_time(methods[k], pair) for k in ((0, 1) if number % 2 else (1, 0))}
        check_lengths(answers[0][0], answers[1][0])
        times.append((answers[0][1], answers[1][1]))
    return np.array(times)


def drive(blocked: NDArray[np.bool_], start: Cell, goal: Cell, found: Times) -> None:
    """Drive through a map that is unknown at first, and add the times."""
    world, known, cell = GridWorld(blocked), np.zeros_like(blocked), start
    routes = DStarLite(known, goal)
    way, place = route_of(routes.route_from(start)).cells, 0

    def repair(new: NDArray[np.int64], cell: Cell) -> Route:
        routes.update_cells(new, True)
        return route_of(routes.route_from(cell))

    for _ in range(STEPS_MAX):
        cells, occupied = world.observe(cell, SENSOR_RANGE)
        new = cells[occupied & ~known[tuple(cells.T)]]
        known[tuple(new.T)] = True
        if len(new):
            route, milliseconds = cpu_time(repair, new, cell)
            found['repaired'].append(milliseconds)
            if known[tuple(way[place:].T)].any():
                found['on route'].append(milliseconds)
            if len(found['repaired']) % EVERY == 0:
                again, milliseconds = cpu_time(shortest_route, known, cell, goal)
                found['scratch'].append(milliseconds)
                fresh = cpu_time(lambda at=cell: DStarLite(known, goal).route_from(at))
                found['new D* Lite'].append(fresh[1])
                check_lengths(route.length, route_of(again).length)
            way, place = route.cells, 0
        if cell == goal:
            return
        place += 1
        cell = (int(way[place, 0]), int(way[place, 1]))


def compare_costs(kind: str, side: int, count: int) -> dict[str, NDArray[np.float64]]:
    """Return times [ms], lengths [cells] and gaps [mm] of shortest and of least-cost routes, shape (count, 2)."""
    planner = PlannerSettings()
    block = np.ones((COARSE, COARSE), dtype=bool)
    distances = clearance(np.kron(GRID_MAPS[kind](side // COARSE, 1), block), RESOLUTION)
    radius = planner.robot_radius + max(DrivingSettings().clearance_margin, MARGIN_CELLS_MIN * RESOLUTION)
    costs = inflation_costs(distances, radius, planner)
    blocked, found = costs > COST_MAX, defaultdict[str, list[list[float]]](list)
    methods: tuple[Callable[[tuple[Cell, Cell]], Route], ...] = (
        lambda ends: route_of(shortest_route(blocked, *ends)),
        lambda ends: route_of(DStarLite(costs, ends[1], planner.cost_travel_multiplier).route_from(ends[0])),
    )
    pairs = pairs_of(blocked, count)
    _ = [method(pairs[0]) for method in methods]  # warm
    for pair in pairs:
        taken = [cpu_time(method, pair) for method in methods]
        found['ms'].append([milliseconds for _, milliseconds in taken])
        found['length'].append([max(route.length, 1.0) for route, _ in taken])
        gaps = [distances[tuple(route.cells.T)].min() - radius for route, _ in taken]
        found['gap'].append([1e3 * min(gap, planner.inflation_radius) for gap in gaps])
    return {name: np.array(values) for name, values in found.items()}


def main(run: Run, side: int, pairs: int, drives: int) -> None:
    """Measure plans and replans."""
    use_one_core()
    maps = speed_maps(side)
    peer = run.peer('nano_astar', 'nano-astar==0.1.2')
    if peer is not None:
        table = run.table('Known maps', 'map | ours ms: median / 95 % | nano-astar | ours over nano-astar')
        compared = {name: compare(blocked, pairs, peer.astar) for name, blocked in progress(maps.items())}
        compared['all'] = np.concatenate(list(compared.values()))
        for name, times in compared.items():
            table.add(name, *(time(column) for column in times.T), ratio(times[:, 0], times[:, 1], '.2f'))
    heads = 'map | shortest ms: median / 95 % | least cost | least cost over shortest'
    table = run.table('Costs', heads, 'length: median / 95 % / max | gap mm: shortest, median | least cost, median')
    for kind in progress(GRID_MAPS):
        results = compare_costs(kind, side, pairs)
        lengths = error(results['length'][:, 1] / results['length'][:, 0], '.3f')
        gaps = [error(column, '.0f', shown=(50.0,), better='higher') for column in results['gap'].T]
        slower = ratio(results['ms'][:, 1], results['ms'][:, 0], '.1f')
        table.add(kind, *(time(column) for column in results['ms'].T), slower, lengths, *gaps)
    heads = 'map | replans | replanned ms: median / 95 % | new obstacle on the route | from scratch'
    table = run.table('Unknown maps', heads, 'replan over from scratch | new D* Lite')
    for name in progress(GRID_MAPS):
        found = Times(list)
        for start, goal in pairs_of(maps[name], drives):
            drive(maps[name], start, goal, found)
        taken = [time(found[column], '.3f') for column in ('repaired', 'on route', 'scratch')]
        units = ratio(found['repaired'], found['scratch'])
        table.add(name, len(found['repaired']), *taken, units, time(found['new D* Lite']))


if __name__ == '__main__':
    run_benchmark(
        main,
        side=Option(1024, 512, 'of the maps [cells]'),
        pairs=Option(50, 10, 'start and goal, of each known map'),
        drives=Option(4, 1, 'of each unknown map'),
    )
