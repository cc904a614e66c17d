"""D* Lite: replans the shortest route to one goal while the robot moves and the map changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reward_planner.core.reward_planner_error import RewardPlannerError
from reward_planner.core.route.incremental_search import (
    NO_WAY,
    OpenCells,
    SearchState,
    mend,
    units_between,
    with_cell,
    write_changes,
)
from reward_planner.core.route.octile import route_length
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route, refuse_ends

_CHANGES_MAX = 100_000
"""With more changed cells since the last route, a search from scratch is faster than replanning."""


class IncrementalRoute:
    """Incremental planner to one goal; its routes are as short as those of `shortest_route`.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns); it is copied.
        goal: row and column of the goal.
    """

    def __init__(self, blocked: NDArray[np.bool_], goal: tuple[int, int]) -> None:
        around = np.pad(blocked, 1, constant_values=True)
        self._blocked = around[1:-1, 1:-1]
        self._goal = goal
        inside = 0 <= goal[0] < blocked.shape[0] and 0 <= goal[1] < blocked.shape[1]
        width = around.shape[1]
        number = (goal[0] + 1) * width + goal[1] + 1 if inside else 0
        lengths, promises = np.empty((2, around.size), dtype=np.int64)
        self._state = SearchState(around.reshape(-1), lengths, promises, width, number)
        self._begin_anew()

    def _begin_anew(self) -> None:
        """Discard the search; the map stays."""
        self._state.lengths[:] = self._state.promises[:] = NO_WAY
        self._opened = OpenCells(np.empty(1024, dtype=np.int64), np.empty(1024, dtype=np.int32), 0)
        self._start: int | None = None
        self._moved = 0
        self._changed: list[NDArray[np.int64]] = []

    @property
    def blocked(self) -> NDArray[np.bool_]:
        """Cells that the robot cannot enter, shape (rows, columns), read-only."""
        view = self._blocked.view()
        view.flags.writeable = False
        return view

    def change(self, cells: ArrayLike, blocked: ArrayLike) -> None:
        """Set cells blocked or free.

        Args:
            cells: rows and columns, shape (n, 2).
            blocked: whether each cell is blocked, shape (n,).

        Raises:
            RewardPlannerError: a cell is outside of the map.
        """
        places = np.ascontiguousarray(cells, dtype=np.int64).reshape(-1, 2)
        # Copied, because broadcast_to gives read-only arrays, for which numba would compile the kernel again.
        now = np.broadcast_to(np.asarray(blocked, dtype=np.bool_), len(places)).copy()
        if len(places) and (places.min() < 0 or (places.max(axis=0) >= self._blocked.shape).any()):
            raise RewardPlannerError(f'a cell to change is outside of the map of {self._blocked.shape} cells')
        changed = write_changes(self._state, places, now)
        if self._start is None:
            return  # no search to update yet
        self._changed.append(changed)
        if sum(map(len, self._changed)) > _CHANGES_MAX:
            self._begin_anew()

    def route_from(self, start: tuple[int, int]) -> Route | NoRoute:
        """Return a shortest route from the robot's cell, row and column."""
        refused = refuse_ends(self._blocked, start, self._goal)
        if refused is not None:
            return refused
        number = (start[0] + 1) * self._state.width + start[1] + 1
        if self._start is None:
            self._state.promises[self._state.goal] = 0
            self._opened = with_cell(self._state, self._opened, self._state.goal, number, 0)
        else:
            self._moved += units_between(self._state, self._start, number)
        changed = np.concatenate(self._changed) if self._changed else np.empty(0, dtype=np.int64)
        self._opened, cells = mend(self._state, self._opened, changed, number, self._moved)
        self._start, self._changed = number, []
        if len(cells) == 0:
            return NoRoute(NoRouteReason.UNREACHABLE)
        return Route(cells, route_length(cells))
