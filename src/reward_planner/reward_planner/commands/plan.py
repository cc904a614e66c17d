"""``plan``: plans a route on a map_server map and writes CSV and PNG, without ROS running."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reward_planner.core.occupancy_map import inflate_obstacles
from reward_planner.core.planner_settings import PlannerSettings, RewardSettings
from reward_planner.core.reward.reward_walk import explained_walk, reward_route
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import NoRoute
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
    # Unknown cells are free; the robot's centre keeps its radius from obstacles.
    frame = grid.frame
    blocked = inflate_obstacles(grid.occupied(), frame.resolution, settings.robot_radius)
    start, goal = ((int(row), int(column)) for row, column in frame.cell_of([options.start, options.goal]))
    if settings.mode == 'optimal':
        route = shortest_route(blocked, start, goal)
    else:
        route = reward_route(blocked, start, goal, reward)
    cells = np.empty((0, 2), dtype=np.int64) if isinstance(route, NoRoute) else route.cells
    if options.png is not None:
        save_picture(options.png, draw_route(grid, blocked, cells))
    if isinstance(route, NoRoute):
        print(f'plan: {options.map}: {route.value}', file=sys.stderr)
        return 1
    if options.csv is not None:
        save_route_table(options.csv, frame.centre_of(cells))
    if options.explain is not None:
        walk = explained_walk(blocked, start, goal, reward, len(cells) - 1)
        save_reward_table(options.explain, walk, frame)
    print(f'{route.length * frame.resolution:.3f} m, {len(cells)} cells of {frame.resolution:g} m')
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


if __name__ == '__main__':
    sys.exit(main())
