"""D* Lite: replans the shortest or least-cost route to one goal while the robot moves and the map changes."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.d_star_lite_kernels import (
    UNREACHED,
    WEIGHT_BITS,
    OpenList,
    SearchState,
    apply_changes,
    cell_distance,
    insert_if_inconsistent,
    replan,
)
from reward_planner.core.route.route import COST_MAX, LETHAL, NoRoute, Route, check_endpoints

_CHANGES_MAX = 100_000  # with more changed cells since the last route, a search from scratch is faster


class DStarLite:
    """Incremental planner to one goal (Koenig and Likhachev, AAAI 2002); see `d_star_lite_kernels` for the symbols.

    Without costs its routes are as short as those of `shortest_route`.

    Args:
        costs: cells that the robot cannot enter, or costs of cells, of which those above `COST_MAX` are blocked; uint8,
            shape (rows, columns); it is copied.
        goal: row and column of the goal.
        multiplier: a step between cells of the greatest cost counts as so many more steps.
    """

    def __init__(self, costs: NDArray[np.bool_ | np.uint8], goal: tuple[int, int], multiplier: float = 0.0) -> None:
        padded = np.pad(_as_costs(costs), 1, constant_values=LETHAL)
        self._costs = padded[1:-1, 1:-1]
        self._goal = goal
        inside = 0 <= goal[0] < costs.shape[0] and 0 <= goal[1] < costs.shape[1]
        width = padded.shape[1]
        number = (goal[0] + 1) * width + goal[1] + 1 if inside else 0
        g, rhs = np.empty((2, padded.size), dtype=np.int64)
        weight = round(multiplier / (2 * COST_MAX) * (1 << WEIGHT_BITS))
        self._state = SearchState(padded.reshape(-1), weight, g, rhs, width, number)
        self._reset()

    def _reset(self) -> None:
        """Discard the search; the map stays."""
        self._state.g[:] = self._state.rhs[:] = UNREACHED
        self._open_list = OpenList(np.empty(1024, dtype=np.int64), np.empty(1024, dtype=np.int32), 0)
        self._start: int | None = None
        self._key_modifier = 0
        self._changed: list[NDArray[np.int64]] = []

    @property
    def blocked(self) -> NDArray[np.bool_]:
        """Cells that the robot cannot enter, shape (rows, columns)."""
        return self._costs > COST_MAX

    def update_cells(self, cells: ArrayLike, costs: ArrayLike) -> None:
        """Set cells (rows and columns, shape (n, 2)) blocked or free, or their costs (shape (n,) or one number).

        Raises:
            RewardPlannerError: a cell is outside of the map.
        """
        indices = np.ascontiguousarray(cells, dtype=np.int64).reshape(-1, 2)
        # Copied, because broadcast_to gives read-only arrays, for which numba would compile the kernel again.
        now = np.broadcast_to(_as_costs(np.asarray(costs)), len(indices)).copy()
        if len(indices) and (indices.min() < 0 or (indices.max(axis=0) >= self._costs.shape).any()):
            raise RewardPlannerError(f'a cell to change is outside of the map of {self._costs.shape} cells')
        changed = apply_changes(self._state, indices, now)
        if self._start is None:
            return  # no search to update yet
        self._changed.append(changed)
        if sum(map(len, self._changed)) > _CHANGES_MAX:
            self._reset()

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Return a least-cost route from the robot's cell, row and column (Main, figure 4)."""
        failure = check_endpoints(self._costs, start, self._goal, COST_MAX)
        if failure is not None:
            return failure
        state, cell = self._state, (start[0] + 1) * self._state.width + start[1] + 1
        if self._start is None:
            # Initialize: only the goal is inconsistent, with rhs 0, and in the open list U.
            state.rhs[state.goal] = 0
            self._open_list = insert_if_inconsistent(state, self._open_list, state.goal, cell, 0)
        else:
            # The robot moved: k_m grows by h(s_last, s_start), so that old keys stay lower bounds.
            self._key_modifier += cell_distance(state, self._start, cell)
        # Cells whose edges changed are updated, the search is repaired, and the path is followed.
        changed = np.concatenate([*self._changed, np.empty(0, dtype=np.int64)])
        self._start, self._changed = cell, []
        self._open_list, cells = replan(state, self._open_list, changed, cell, self._key_modifier)
        return Route(cells) if len(cells) else NoRoute.UNREACHABLE


def _as_costs(grid: NDArray[np.bool_ | np.uint8]) -> NDArray[np.uint8]:
    """Return costs: those of an array of blocked cells, or the array itself."""
    if grid.dtype == np.bool_:
        return grid.view(np.uint8) * np.uint8(LETHAL)
    return np.asarray(grid, dtype=np.uint8)
