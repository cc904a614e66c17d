"""Routes on grids."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from reward_planner.core.occupancy_map import OCCUPIED_THRESHOLD, UNKNOWN, clearance
from reward_planner.core.route.route import NoRoute
from reward_planner.core.route.shortest_route import shortest_route
from shirube.inputs import InputError, as_numbers, prepare
from shirube.results import RouteResult


def plan(
    grid: ArrayLike, start: Sequence[int], goal: Sequence[int], *, robot_radius: float = 0.0, unknown: str = 'free'
) -> RouteResult:
    """Return a shortest route of straight and diagonal steps, or the reason for none.

    Args:
        grid: occupancy of each cell as in OccupancyGrid: 0 to 100 %, -1 for unknown; shape (rows, columns).
        start: row and column.
        goal: row and column.
        robot_radius: the robot's centre keeps farther from the centres of occupied cells [cells].
        unknown: whether unknown cells are ``free`` or ``blocked``.

    Raises:
        InputError: an argument that cannot be used.
    """
    cells = as_numbers('grid', grid, (None, None))
    if not cells.size or cells.min() < -1 or cells.max() > 100:
        raise InputError('grid has no cells, or values outside of -1 to 100; give occupancy in per cent')
    if unknown not in ('free', 'blocked'):
        raise InputError(f'unknown is {unknown!r}; choose free or blocked')
    blocked = cells >= OCCUPIED_THRESHOLD
    if robot_radius > 0.0:
        blocked = clearance(blocked, 1.0) <= robot_radius
    if unknown == 'blocked':
        blocked |= cells == UNKNOWN
    ends = [as_numbers(name, end, (2,)) for name, end in (('start', start), ('goal', goal))]
    (row, column), (goal_row, goal_column) = np.floor(ends).astype(int).tolist()
    prepare('reward_planner')
    route = shortest_route(blocked, (row, column), (goal_row, goal_column))
    if isinstance(route, NoRoute):
        return RouteResult(reason=route.value)
    return RouteResult([(int(r), int(c)) for r, c in route.cells], route.length)
