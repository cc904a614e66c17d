"""``plan``: plans a route on a map_server map and writes CSV and PNG, without ROS running."""

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from reward_planner.core.mapping.global_map import CostmapMasks
from reward_planner.core.occupancy_map import FREE_THRESHOLD, UNKNOWN, GridFrame, OccupancyMap, clearance
from reward_planner.core.reward.reward_walk import ExplainedCell, explained_walk, reward_route
from reward_planner.core.reward.step_reward import TERM_NAMES
from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.d_star_lite import DStarLite
from reward_planner.core.route.route import COST_MAX, LETHAL, NoRoute, inflation_costs
from reward_planner.core.route.shortest_route import shortest_route
from reward_planner.core.settings import PlannerSettings, RewardSettings
from reward_planner.files.occupancy_map_file import load_occupancy_map
from shirube_core.files import atomic_write, write_text
from shirube_core.settings import SettingsError, check_settings

_LONG_SIDE_MIN = 800  # least size of the long side of the picture [px]
_FREE, _UNKNOWN, _OCCUPIED, _INFLATED = (255, 255, 255), (205, 205, 205), (0, 0, 0), (200, 215, 250)
_ROUTE, _START, _GOAL = (200, 60, 0), (0, 150, 0), (0, 0, 220)  # BGR
_HEAD = ('number', 'x', 'y', 'to_x', 'to_y', *TERM_NAMES, 'total', 'can_enter', 'taken')


def save_route_table(path: Path, points_map: NDArray[np.float64]) -> None:
    """Write the points of a route in the map frame [m], shape (n, 2), atomically: one line ``x,y`` per cell."""
    lines = [f'{x:.4f},{y:.4f}\n' for x, y in points_map.tolist()]
    write_text(path, ''.join(['x,y\n', *lines]))


def save_reward_table(path: Path, cells: Iterable[ExplainedCell], frame: GridFrame) -> None:
    """Write the rewards along a path atomically: eight lines per cell, one for each step; positions are in metres."""
    lines = [','.join(_HEAD)]
    for number, at in enumerate(cells):
        x, y = frame.centre_of(at.cell)
        for reward in at.rewards:
            rows, columns = reward.step
            to_x, to_y = x + columns * frame.resolution, y + rows * frame.resolution
            terms = (f'{reward.terms.get(name, 0.0):.3f}' for name in TERM_NAMES)
            flags = (int(reward.can_enter), int(reward.step == at.taken))
            places = (f'{place:.4f}' for place in (x, y, to_x, to_y))
            lines.append(','.join(map(str, (number, *places, *terms, f'{reward.total:.3f}', *flags))))
    write_text(path, '\n'.join([*lines, '']))


def draw_route(grid: OccupancyMap, blocked: NDArray[np.bool_], cells: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Return a BGR picture, shape (h, w, 3), one or more pixels per cell; its first line is the map's highest row.

    Inflated obstacles, shape (rows, columns), are tinted; the route is rows and columns, shape (n, 2), n may be 0.
    """
    picture = np.full((*grid.frame.shape, 3), _UNKNOWN, dtype=np.uint8)
    picture[(grid.occupancy >= 0) & (grid.occupancy < FREE_THRESHOLD)] = _FREE
    picture[blocked] = _INFLATED
    picture[grid.occupied()] = _OCCUPIED
    scale = max(1, -(-_LONG_SIDE_MIN // max(grid.frame.shape)))
    large = np.ascontiguousarray(picture[::-1].repeat(scale, axis=0).repeat(scale, axis=1))
    pixels = (scale * (np.stack([cells[:, 1], grid.frame.rows - 1 - cells[:, 0]], axis=1) + 0.5)).astype(np.int32)
    thickness = max(2, scale // 3)
    cv2.polylines(large, [pixels.reshape(-1, 1, 2)], isClosed=False, color=_ROUTE, thickness=thickness)
    for ends, colour in ((pixels[:1], _START), (pixels[-1:], _GOAL)):
        for x, y in ends.tolist():
            cv2.circle(large, (x, y), max(3, scale), colour, -1)
    return large


def save_picture(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a PNG atomically."""
    data = cv2.imencode('.png', pixels)[1]
    with atomic_write(path) as file:
        file.write(data.tobytes())


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
    settings = PlannerSettings(
        options.mode,
        options.robot_radius,
        inflation_radius=options.inflation_radius,
        cost_scaling_factor=options.cost_scaling_factor,
        unknown=options.unknown,
    )
    reward = RewardSettings(visits=options.visits)
    check_settings(settings)
    check_settings(reward)
    if options.explain is not None and settings.mode != 'reward':
        raise RewardPlannerError('--explain needs --mode reward; the shortest route has no rewards')
    grid = load_occupancy_map(options.map, options.resolution)
    frame, costs = grid.frame, plan_costs(grid, settings, options.keepout)
    blocked = costs > COST_MAX
    start, goal = ((int(row), int(column)) for row, column in frame.cell_of([options.start, options.goal]))
    if settings.mode == 'reward':
        route = reward_route(blocked, start, goal, reward)
    elif (blocked == (costs > 0)).all():
        route = shortest_route(blocked, start, goal)
    else:
        route = DStarLite(costs, goal, settings.cost_travel_multiplier).route_from(start)
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


def plan_costs(grid: OccupancyMap, settings: PlannerSettings, keepout: Path | None) -> NDArray[np.uint8]:
    """Return the costs of a map's cells, shape (rows, columns); the robot's centre keeps its radius from obstacles."""
    costs = inflation_costs(clearance(grid.occupied(), grid.frame.resolution), settings.robot_radius, settings)
    if settings.unknown == 'blocked':
        costs[grid.occupancy == UNKNOWN] = LETHAL
    if keepout is not None:
        mask = CostmapMasks(load_occupancy_map(keepout)).keepout_costs(grid.frame)
        costs = costs if mask is None else np.maximum(costs, mask)
    return costs


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
    add('--inflation-radius', type=float, default=_PLANNER.inflation_radius, metavar='R',
        help='routes cost more up to this distance from obstacles [m] (default: %(default)s)')  # fmt: skip
    add('--cost-scaling-factor', type=float, default=_PLANNER.cost_scaling_factor, metavar='K',
        help='decay of this cost [1/m], as in Nav2; 0: the shortest route (default: %(default)s)')  # fmt: skip
    add('--unknown', choices=('free', 'blocked'), default=_PLANNER.unknown,
        help='whether the route may enter unknown cells (default: %(default)s)')  # fmt: skip
    add('--keepout', type=Path, metavar='MASK.yaml', help='keep-out mask in the format of Nav2')
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
