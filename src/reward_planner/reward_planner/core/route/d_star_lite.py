"""D* Lite: replans the shortest route to one goal while the robot moves and the map changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.d_star_lite_kernels import (
    UNREACHED,
    OpenList,
    SearchState,
    apply_changes,
    cell_distance,
    insert_if_inconsistent,
    replan,
)
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route, check_endpoints, route_length

_CHANGES_MAX = 100_000
"""With more changed cells since the last route, a search from scratch is faster than replanning."""


class DStarLite:
    """Incremental planner to one goal; its routes are as short as those of `shortest_route`.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns); it is copied.
        goal: row and column of the goal.
    """

    def __init__(self, blocked: NDArray[np.bool_], goal: tuple[int, int]) -> None:
        padded = np.pad(blocked, 1, constant_values=True)
        self._blocked = padded[1:-1, 1:-1]
        self._goal = goal
        inside = 0 <= goal[0] < blocked.shape[0] and 0 <= goal[1] < blocked.shape[1]
        width = padded.shape[1]
        number = (goal[0] + 1) * width + goal[1] + 1 if inside else 0
        g, rhs = np.empty((2, padded.size), dtype=np.int64)
        self._state = SearchState(padded.reshape(-1), g, rhs, width, number)
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
        """Cells that the robot cannot enter, shape (rows, columns), read-only."""
        view = self._blocked.view()
        view.flags.writeable = False
        return view

    def update_cells(self, cells: ArrayLike, blocked: ArrayLike) -> None:
        """Set cells blocked or free.

        Args:
            cells: rows and columns, shape (n, 2).
            blocked: whether each cell is blocked, shape (n,).

        Raises:
            RewardPlannerError: a cell is outside of the map.
        """
        indices = np.ascontiguousarray(cells, dtype=np.int64).reshape(-1, 2)
        # Copied, because broadcast_to gives read-only arrays, for which numba would compile the kernel again.
        now = np.broadcast_to(np.asarray(blocked, dtype=np.bool_), len(indices)).copy()
        if len(indices) and (indices.min() < 0 or (indices.max(axis=0) >= self._blocked.shape).any()):
            raise RewardPlannerError(f'a cell to change is outside of the map of {self._blocked.shape} cells')
        changed = apply_changes(self._state, indices, now)
        if self._start is None:
            return  # no search to update yet
        self._changed.append(changed)
        if sum(map(len, self._changed)) > _CHANGES_MAX:
            self._reset()

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Return a shortest route from the robot's cell, row and column."""
        failure = check_endpoints(self._blocked, start, self._goal)
        if failure is not None:
            return failure
        number = (start[0] + 1) * self._state.width + start[1] + 1
        if self._start is None:
            self._state.rhs[self._state.goal] = 0
            self._open_list = insert_if_inconsistent(
                self._state, self._open_list, self._state.goal, number, 0
            )
        else:
            self._key_modifier += cell_distance(self._state, self._start, number)
        changed = np.concatenate(self._changed) if self._changed else np.empty(0, dtype=np.int64)
        self._open_list, cells = replan(self._state, self._open_list, changed, number, self._key_modifier)
        self._start, self._changed = number, []
        if len(cells) == 0:
            return NoRoute(NoRouteReason.UNREACHABLE)
        return Route(cells, route_length(cells))
