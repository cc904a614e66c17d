"""Time of plans on maps of 1024x1024 cells: from scratch against nano-astar, and replanning against from scratch.

Known maps: all methods find the same lengths by the same corner rule; they take turns on the same pairs, warm. The time
of ours holds all it does, from the array of the map to the route. Unknown maps: a robot that sees 6 cells far follows
its plan; at every step where it sees a new obstacle, the plan is repaired, and at every tenth also made from scratch.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from _grid_drives import SENSOR_RANGE
from _timed_answers import use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route
from scene_simulator.room.grid_maps import GRID_MAPS, maze, random_field, rooms
from scene_simulator.room.grid_world import GridWorld

STEPS_MAX = 1500
EVERY = 10
Pair = tuple[tuple[int, int], tuple[int, int]]


class Replans(NamedTuple):
    """Times of one map [s].

    Attributes:
        first: times of the first plan, including all state kept for replanning.
        repaired: time of each replan.
        on_route: times of the replans whose new obstacle was on the route.
        scratch: times of `shortest_route` on the same map.
        reinitialized: times of the incremental search restarted from scratch.
    """

    first: list[float]
    repaired: list[float]
    on_route: list[float]
    scratch: list[float]
    reinitialized: list[float]


def speed_maps(side: int) -> dict[str, NDArray[np.bool_]]:
    """Return maps of many kinds by name."""
    maps = {kind: make(side, 1) for kind, make in GRID_MAPS.items()}
    maps |= {f'random field, {100 * share:.0f} %': random_field(side, 2, share) for share in (0.1, 0.3, 0.35)}
    maps['rooms of 32'] = rooms(side, 1, 32)
    maps['maze of 1, no loops'] = maze(side, 1, 1, 0.0)
    maps['empty'] = np.zeros((side, side), dtype=bool)
    return maps


def pairs_of(blocked: NDArray[np.bool_], count: int) -> list[Pair]:
    """Return pairs of free cells with a route between them."""
    rng, free = np.random.default_rng(5), np.argwhere(~blocked)
    pairs: list[Pair] = []
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


def time_call(call: Callable[..., Any], *arguments: object) -> tuple[float, Any]:
    """Return the processor time of a call [s], and its result."""
    begin = time.process_time()
    result = call(*arguments)
    return time.process_time() - begin, result


def compare(blocked: NDArray[np.bool_], count: int, peer: Callable[..., Any]) -> NDArray[np.float64]:
    """Return the times of ours and of the peer's plans, shape (count, 2) [s]."""
    octets = np.ascontiguousarray(blocked).view(np.uint8)
    methods = (
        lambda ends: route_of(shortest_route(blocked, *ends)).length,
        lambda ends: peer(octets, *ends)[1],
    )
    times = []
    for number, pair in enumerate(pairs_of(blocked, count)):
        order = (0, 1) if number % 2 else (1, 0)
        answers = {k: time_call(methods[k], pair) for k in order}
        if abs(answers[0][1] - answers[1][1]) > 1e-6:
            raise AssertionError(f'{pair}: lengths {answers[0][1]} and {answers[1][1]}')
        times.append((answers[0][0], answers[1][0]))
    return np.array(times)


def replan(blocked: NDArray[np.bool_], count: int) -> Replans:
    """Drive through a map that is unknown at first."""
    found = Replans([], [], [], [], [])
    for start, goal in pairs_of(blocked, count):
        _drive(blocked, start, goal, found)
    return found


def _drive(blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int], found: Replans) -> None:
    world, known, cell = GridWorld(blocked), np.zeros_like(blocked), start
    begin = time.process_time()
    routes = DStarLite(known, goal)
    route = route_of(routes.route_from(start))
    found.first.append(time.process_time() - begin)
    way, place = route.cells, 0
    for _ in range(STEPS_MAX):
        cells, occupied = world.observe(cell, SENSOR_RANGE)
        new = cells[occupied & ~known[tuple(cells.T)]]
        known[tuple(new.T)] = True
        if len(new):
            seconds, route = time_call(_repair, routes, new, cell)
            found.repaired.append(seconds)
            if known[tuple(way[place:].T)].any():
                found.on_route.append(seconds)
            if len(found.repaired) % EVERY == 0:
                _compare_with_scratch(known, cell, goal, route.length, found)
            way, place = route.cells, 0
        if cell == goal:
            return
        place += 1
        cell = (int(way[place, 0]), int(way[place, 1]))


def _repair(routes: DStarLite, new: NDArray[np.int64], cell: tuple[int, int]) -> object:
    routes.update_cells(new, True)
    return routes.route_from(cell)


def _compare_with_scratch(
    known: NDArray[np.bool_], cell: tuple[int, int], goal: tuple[int, int], length: float, found: Replans
) -> None:
    seconds, route = time_call(shortest_route, known, cell, goal)
    found.scratch.append(seconds)
    found.reinitialized.append(time_call(lambda: DStarLite(known, goal).route_from(cell))[0])
    if abs(route.length - length) > 1e-6:
        raise AssertionError(f'{cell} to {goal}: lengths {route.length} and {length}')


def print_comparison(maps: dict[str, NDArray[np.bool_]], count: int, peer: Callable[..., Any]) -> None:
    """Print our times and the peer's."""
    print(
        '\n| known map | ours ms: median / 95 % | nano-astar | ratio of medians | ratio a pair: median / 95 % |'
    )
    print('|---|---|---|---|---|')
    every = []
    for name, blocked in tqdm(maps.items(), leave=False):
        every.append(compare(blocked, count, peer))
        _print_times(name, every[-1])
    _print_times('all', np.concatenate(every))


def _print_times(name: str, times: NDArray[np.float64]) -> None:
    (ours, peers), (ours_high, peers_high) = np.percentile(1e3 * times, [50, 95], axis=0)
    ratio, ratio_high = np.percentile(times[:, 0] / times[:, 1], [50, 95])
    print(
        f'| {name} | {ours:.2f} / {ours_high:.1f} | {peers:.2f} / {peers_high:.1f} | {ours / peers:.2f} '
        f'| {ratio:.2f} / {ratio_high:.2f} |'
    )


def print_replans(maps: dict[str, NDArray[np.bool_]], count: int) -> None:
    """Print replanning against planning from scratch."""
    print(
        '\n| unknown map | replans | replan ms: median / 95 % / mean | new obstacle on the route '
        '| from scratch: median | times faster | D* Lite from scratch |'
    )
    print('|---|---|---|---|---|---|---|')
    for name in GRID_MAPS:
        found = replan(maps[name], count)
        median, high = np.percentile(1e3 * np.array(found.repaired), [50, 95])
        hit, scratch, reinitialized = (
            1e3 * np.median(part) for part in (found.on_route, found.scratch, found.reinitialized)
        )
        print(
            f'| {name} | {len(found.repaired)} | {median:.3f} / {high:.2f} / {1e3 * np.mean(found.repaired):.3f} '
            f'| {len(found.on_route)}: {hit:.3f} | {scratch:.2f} | {scratch / median:.0f} | {reinitialized:.1f} |'
        )


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--side', type=int, default=1024, help='of the maps [cells]')
    parser.add_argument('--pairs', type=int, default=100, help='start and goal, of each known map')
    parser.add_argument('--drives', type=int, default=10, help='of each unknown map')
    arguments = parser.parse_args()
    use_one_core()
    maps = speed_maps(arguments.side)
    try:
        from nano_astar import astar  # noqa: PLC0415
    except ImportError:
        print('route_speed: nano-astar is not here to compare with; pip install nano-astar', file=sys.stderr)
    else:
        print_comparison(maps, arguments.pairs, astar)
    print_replans(maps, arguments.drives)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
