"""Result of planning: a route, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.grid.grid_frame import GridFrame


@dataclass(frozen=True)
class Route:
    """A route of neighbouring cells.

    Attributes:
        cells: rows and columns from start to goal, shape (n, 2); one cell if the start is the goal.
        length: sum of the steps, 1 for a straight and sqrt(2) for a diagonal one [cells].
    """

    cells: NDArray[np.int64]
    length: float

    def points_map(self, frame: GridFrame) -> NDArray[np.float64]:
        """Return the centres of the cells in the map frame, shape (n, 2) [m]."""
        return frame.centre_of(self.cells)

    def length_in_metres(self, frame: GridFrame) -> float:
        """Return the length on a grid of some resolution [m]."""
        return self.length * frame.resolution


class NoRouteReason(Enum):
    """Why there is no route."""

    START_OUTSIDE = 'the start is outside of the map'
    GOAL_OUTSIDE = 'the goal is outside of the map'
    START_BLOCKED = 'the start is in an obstacle or too near to one'
    GOAL_BLOCKED = 'the goal is in an obstacle or too near to one'
    UNREACHABLE = 'obstacles block every path'
    GAVE_UP = 'the reward rule did not reach the goal'


@dataclass(frozen=True)
class NoRoute:
    """No route, and the reason."""

    reason: NoRouteReason


def check_endpoints(
    blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int]
) -> NoRoute | None:
    """Return why no route can start or end at these cells, or None.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns).
        start: row and column of the start.
        goal: row and column of the goal.
    """
    rows, columns = blocked.shape
    ends = (
        (goal, NoRouteReason.GOAL_OUTSIDE, NoRouteReason.GOAL_BLOCKED),
        (start, NoRouteReason.START_OUTSIDE, NoRouteReason.START_BLOCKED),
    )
    for (row, column), outside, inside in ends:
        if not (0 <= row < rows and 0 <= column < columns):
            return NoRoute(outside)
        if blocked[row, column]:
            return NoRoute(inside)
    return None
