"""``plan``: plans a route on a map_server map and writes CSV and PNG, without ROS running.

Planning on a static map.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from reward_planner.core.occupancy_map import OccupancyMap, inflate_obstacles
from reward_planner.core.planner_settings import PlannerSettings, RewardSettings
from reward_planner.core.reward.reward_walk import explained_walk, reward_route
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route
from reward_planner.files.occupancy_map_file import load_occupancy_map
from reward_planner.files.route_files import draw_route, save_picture, save_reward_table, save_route_table
from shirube_core.settings import SettingsError, check_settings

_PLANNER, _REWARD = PlannerSettings(), RewardSettings()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 if there is no route or a file is invalid."""
    options = make_parser().parse_args(arguments)
    try:
        return plan(options)
    except (RewardPlannerError, SettingsError) as fault:
        print(f'plan: {fault}', file=sys.stderr)
    except OSError as fault:
        print(f'plan: {fault.filename}: {fault.strerror}; choose a writable path', file=sys.stderr)
    return 1


def plan(options: argparse.Namespace) -> int:
    """Plan, write the requested files, and return the exit code."""
    settings = PlannerSettings(options.mode, options.robot_radius)
    reward = RewardSettings(visits=options.visits)
    check_settings(settings)
    check_settings(reward)
    if options.explain is not None and settings.mode != 'reward':
        raise RewardPlannerError('--explain needs --mode reward; the shortest route has no rewards')
    grid = load_occupancy_map(options.map, options.resolution)
    route = plan_on_map(grid, options.start, options.goal, settings, reward)
    cells = np.empty((0, 2), dtype=np.int64) if isinstance(route, NoRoute) else route.cells
    blocked = inflate_obstacles(grid.occupied(), grid.frame.resolution, settings.robot_radius)
    if options.png is not None:
        save_picture(options.png, draw_route(grid, blocked, cells))
    if isinstance(route, NoRoute):
        print(f'plan: {options.map}: {route.reason.value}', file=sys.stderr)
        return 1
    if options.csv is not None:
        save_route_table(options.csv, route.points_map(grid.frame))
    if options.explain is not None:
        start, goal = ((int(row), int(column)) for row, column in (cells[0], cells[-1]))
        walk = explained_walk(blocked, start, goal, reward, len(cells) - 1)
        save_reward_table(options.explain, walk, grid.frame)
    print(f'{route.length_in_metres(grid.frame):.3f} m, {len(cells)} cells of {grid.frame.resolution:g} m')
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='plan', description='Plan a route on a map_server map; writes it as CSV (x,y [m]) and PNG.'
    )
    add = parser.add_argument
    add('map', type=Path, metavar='MAP.yaml', help='YAML file of the map')
    add('--start', type=float, nargs=2, required=True, metavar=('X', 'Y'), help='start in the map frame [m]')
    add('--goal', type=float, nargs=2, required=True, metavar=('X', 'Y'), help='goal in the map frame [m]')
    add('--mode', default=_PLANNER.mode, help='planning mode: optimal or reward (default: %(default)s)')
    add(
        '--visits',
        default=_REWARD.visits,
        help='penalty of visited cells in mode reward: once or counted (default: %(default)s)',
    )
    add('--robot-radius', type=float, default=_PLANNER.robot_radius, metavar='R',
        help='robot radius; its centre keeps farther from obstacles [m] (default: %(default)s)')  # fmt: skip
    add('--resolution', type=float, metavar='M', help='required resolution of the map [m] (default: any)')
    add('--csv', type=Path, metavar='FILE', help='output file of the route')
    add('--png', type=Path, metavar='FILE', help='output file of a picture of the route')
    add(
        '--explain',
        type=Path,
        metavar='FILE',
        help='output file of the rewards of all steps along the route, in mode reward (CSV)',
    )
    return parser


def plan_on_map(
    grid: OccupancyMap,
    start_map: ArrayLike,
    goal_map: ArrayLike,
    settings: PlannerSettings,
    reward: RewardSettings,
) -> Route | NoRoute:
    """Plan a route between two points; unknown cells are free.

    Args:
        grid: occupancy grid to plan on.
        start_map: start in the map frame [m], shape (2,).
        goal_map: goal in the map frame [m], shape (2,).
        settings: planning mode and robot radius.
        reward: settings of the reward rule, for mode reward.

    Raises:
        RewardPlannerError: a coordinate is not finite.
    """
    blocked = inflate_obstacles(grid.occupied(), grid.frame.resolution, settings.robot_radius)
    ends = grid.frame.cell_of(np.stack([np.asarray(start_map), np.asarray(goal_map)]))
    start, goal = ((int(row), int(column)) for row, column in ends)
    if settings.mode == 'optimal':
        return shortest_route(blocked, start, goal)
    return reward_route(blocked, start, goal, reward)


if __name__ == '__main__':
    sys.exit(main())
