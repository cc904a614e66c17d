"""Drives through unknown terrain: how often the goal is reached, and how much longer than the shortest route.

MovingAI's arena (``SHIRUBE_DATA`` names the folder with planner/arena.map) and made-up maps as large as it. A robot
sees 6 cells far in line of sight and takes what it does not know for free. After 20 times the shortest route a drive
has failed.
"""

from __future__ import annotations

import argparse

import numpy as np
from _grid_drives import GIVE_UP, Drive, Driver, drive_optimally, reward_driver
from _grid_tasks import GridTask, benchmark_maps, solvable_tasks, unsolvable_tasks
from _timed_answers import use_one_core
from numpy.typing import NDArray
from tqdm import tqdm

from reward_planner.core.planner_settings import RewardSettings
from scene_simulator.grid_truth import distances_from

LENGTH_RATIO_MAX = 500.0
PLANNED_MAX = 1000
METHODS: dict[str, Driver] = {
    '`optimal`': drive_optimally,
    '`reward`, visits once (the paper)': reward_driver(RewardSettings('once', PLANNED_MAX)),
    '`reward`, visits counted': reward_driver(RewardSettings('counted', PLANNED_MAX)),
    'visits once, no virtual search': reward_driver(RewardSettings('once', 0)),
    'visits counted, no virtual search': reward_driver(RewardSettings('counted', 0)),
}
EXPLAINED = ('`optimal`', '`reward`, visits counted')  # what is to reach the goal; each failure is listed

Drives = dict[str, list[tuple[GridTask, Drive]]]


def print_summary(results: dict[str, Drives]) -> None:
    """Print a line a method."""
    print('\n| method | goal reached | length / shortest: mean | median | 95 % | max |')
    print('|---|---|---|---|---|---|')
    for method, drives in results.items():
        every = [pair for pairs in drives.values() for pair in pairs]
        ratios = ratios_of(every)
        share = 100.0 * len(ratios) / len(every)
        print(
            f'| {method} | {len(ratios)} of {len(every)} ({share:.1f} %) | {ratios.mean():.3f} '
            f'| {np.median(ratios):.3f} | {np.percentile(ratios, 95):.2f} | {ratios.max():.2f} |'
        )


def print_maps(results: dict[str, Drives]) -> None:
    """Print success and mean ratio of each method on each map."""
    print('\n| map |' + ''.join(f' {method} |' for method in results))
    print('|---|' + '---|' * len(results))
    for name in next(iter(results.values())):
        cells = []
        for drives in results.values():
            ratios = ratios_of(drives[name])
            cells.append(f' {100 * len(ratios) / len(drives[name]):.0f} %, {ratios.mean():.2f} |')
        print(f'| {name} |' + ''.join(cells))


def ratios_of(pairs: list[tuple[GridTask, Drive]]) -> NDArray[np.float64]:
    """Return length over shortest length of the drives that reached the goal."""
    return np.array([drive.length / task.length for task, drive in pairs if drive.ended == 'goal'])


def print_failures(maps: dict[str, NDArray[np.bool_]], method: str, drives: Drives) -> None:
    """Print what the robot did in the drives that failed, and what happens when they are let go on."""
    print(
        f'\n| {method} fails on | from | to | shortest (straight) | cells entered of those in reach '
        '| new in the second half | let go on, arrives after |'
    )
    print('|---|---|---|---|---|---|---|')
    for name, pairs in drives.items():
        for task, drive in pairs:
            if drive.ended == 'goal':
                continue
            longer = METHODS[method](maps[name], task, LENGTH_RATIO_MAX * task.length)
            arrives = f'{longer.length / task.length:.1f} x' if longer.ended == 'goal' else longer.ended
            straight = np.hypot(*np.subtract(task.start, task.goal))
            reachable = np.isfinite(distances_from(maps[name], task.start)).sum()
            print(
                f'| {name} | {task.start} | {task.goal} | {task.length:.1f} ({straight:.1f}) '
                f'| {drive.entered} of {reachable} | {drive.entered_late} | {arrives} |'
            )


def print_unsolvable(maps: dict[str, NDArray[np.bool_]], count: int) -> None:
    """Print what is said of goals that cannot be reached."""
    print('\n| method | unreachable goals | reported | length driven until then: median cells |')
    print('|---|---|---|---|')
    tasks = [(blocked, task) for blocked in maps.values() for task in unsolvable_tasks(blocked, count, 2)]
    for method in EXPLAINED:
        drives = [METHODS[method](blocked, task, 1e5) for blocked, task in tqdm(tasks, leave=False)]
        reported = [drive.length for drive in drives if drive.ended == 'unreachable']
        print(f'| {method} | {len(tasks)} | {len(reported)} | {np.median(reported):.0f} |')


def main() -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument('--side', type=int, default=49, help='of the made-up maps [cells]')
    parser.add_argument('--seeds', type=int, default=2, help='made-up maps of each kind')
    parser.add_argument('--pairs', type=int, default=150, help='start and goal, of each map')
    parser.add_argument('--only', choices=('optimal', 'once', 'counted'), help='some methods')
    arguments = parser.parse_args()
    use_one_core()
    maps = benchmark_maps(arguments.side, arguments.seeds)
    tasks = {name: solvable_tasks(blocked, arguments.pairs, 1) for name, blocked in maps.items()}
    methods = {name: driver for name, driver in METHODS.items() if (arguments.only or '') in name}
    bar = tqdm(total=len(methods) * len(maps) * arguments.pairs, unit='drive', leave=False)
    results: dict[str, Drives] = {method: {name: [] for name in maps} for method in methods}
    for method, driver in methods.items():
        for name, blocked in maps.items():
            for task in tasks[name]:
                results[method][name].append((task, driver(blocked, task, GIVE_UP * task.length)))
                bar.update()
    bar.close()
    print_summary(results)
    print_maps(results)
    for method in EXPLAINED:
        if method in results:
            print_failures(maps, method, results[method])
    print_unsolvable(maps, 20)
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
