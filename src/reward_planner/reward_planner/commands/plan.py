"""``plan``: the route on a map of map_server, as CSV and PNG, without ROS running."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reward_planner.core.grid.footprint import blocked_cells
from reward_planner.core.known_map_plan import plan_on_map
from reward_planner.core.planner_settings import PlannerSettings
from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.route import NoRoute
from reward_planner.files.occupancy_map_file import load_occupancy_map
from reward_planner.files.route_picture import draw_route, save_picture
from reward_planner.files.route_table import save_route_table
from shirube_settings import SettingsError, check_settings

_PLANNER, _REWARD = PlannerSettings(), RewardSettings()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 1 when there is no route or a file is bad."""
    options = make_parser().parse_args(arguments)
    try:
        return plan(options)
    except (RewardPlannerError, SettingsError) as fault:
        print(f'plan: {fault}', file=sys.stderr)
    except OSError as fault:
        print(f'plan: {fault.filename}: {fault.strerror}; choose a writable place', file=sys.stderr)
    return 1


def plan(options: argparse.Namespace) -> int:
    """Plan, write what is asked for, and return the exit code."""
    settings = PlannerSettings(options.mode, options.robot_radius)
    reward = RewardSettings(visits=options.visits)
    check_settings(settings)
    check_settings(reward)
    for path in filter(None, (options.png, options.csv)):
        if not path.parent.is_dir():
            raise RewardPlannerError(f'{path}: there is no such folder; make it, or choose another')
    grid = load_occupancy_map(options.map, options.resolution)
    route = plan_on_map(grid, options.start, options.goal, settings, reward)
    cells = np.empty((0, 2), dtype=np.int64) if isinstance(route, NoRoute) else route.cells
    if options.png is not None:
        blocked = blocked_cells(grid.occupied(), grid.frame.resolution, settings.robot_radius)
        save_picture(options.png, draw_route(grid, blocked, cells))
    if isinstance(route, NoRoute):
        print(f'plan: {options.map}: {route.reason.value}', file=sys.stderr)
        return 1
    if options.csv is not None:
        save_route_table(options.csv, route.points_map(grid.frame))
    print(f'{route.metres(grid.frame):.3f} m, {len(cells)} cells of {grid.frame.resolution:g} m')
    return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the command's options."""
    parser = argparse.ArgumentParser(
        prog='plan',
        description='Find the way on a map of map_server; writes it as CSV (x,y [m]) and PNG.',
    )
    add = parser.add_argument
    add('map', type=Path, metavar='MAP.yaml', help='the YAML file of the map')
    add('--start', type=float, nargs=2, required=True, metavar=('X', 'Y'), help='in the map frame [m]')
    add('--goal', type=float, nargs=2, required=True, metavar=('X', 'Y'), help='in the map frame [m]')
    add('--mode', default=_PLANNER.mode, help='optimal or reward (default: %(default)s)')
    add('--visits', default=_REWARD.visits, help='in mode reward: once or counted (default: %(default)s)')
    add('--robot-radius', type=float, default=_PLANNER.robot_radius, metavar='R',
        help='the centre of the robot keeps farther from obstacles [m] (default: %(default)s)')  # fmt: skip
    add('--resolution', type=float, metavar='M', help='refuse a map with other cells [m] (default: any)')
    add('--csv', type=Path, metavar='FILE', help='the route')
    add('--png', type=Path, metavar='FILE', help='a picture of it')
    return parser


if __name__ == '__main__':
    sys.exit(main())
