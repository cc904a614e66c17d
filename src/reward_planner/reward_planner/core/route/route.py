"""Result of planning: a route, or the reason why there is none; and the octile lengths of routes.

Octile lengths are integers that compare exactly as the true lengths do. A diagonal step is sqrt(2) times a straight
one. 665857/470832 is a convergent of sqrt(2), so no fraction with a smaller denominator is between the two. Sums of
these integers order two routes as their true lengths do, and are equal only if those are, as long as their numbers of
diagonal steps differ by less than 470832.
"""

import math
from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.settings import PlannerSettings

_DENSE = 500  # points from the robot on that stay as they are


def thin_path(points_map: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Return a path whose straight parts beyond the first points are one segment each (Douglas and Peucker, 1973).

    Args:
        points_map: points [m], shape (n, 2).
        tolerance: largest deviation [m].
    """
    if len(points_map) <= 2 * _DENSE:
        return points_map
    dense, rest = points_map[:_DENSE], points_map[_DENSE:]
    # Relative to its begin, because OpenCV rounds to single precision.
    corners = cv2.approxPolyDP((rest - rest[0]).astype(np.float32)[:, None], tolerance, False)
    return np.concatenate([dense, corners[:-1, 0] + rest[0], rest[-1:]])


STRAIGHT = 470832
DIAGONAL = 665857

COST_MAX = 252  # greatest cost of a cell that the robot may enter; 253 and 254 are blocked, as in Nav2
LETHAL = 254
HIDDEN_FACTOR = 3.0
"""A metre where the robot may meet what an obstacle hides counts as so many at other cells of the greatest cost."""


@dataclass(frozen=True)
class Route:
    """A route of neighbouring cells.

    Attributes:
        cells: rows and columns from start to goal, shape (n, 2); one cell if the start is the goal.
    """

    cells: NDArray[np.int64]

    @property
    def length(self) -> float:
        """Sum of the steps, 1 for a straight and sqrt(2) for a diagonal one [cells]."""
        return route_length(self.cells)


class NoRoute(Enum):
    """Why there is no route."""

    START_OUTSIDE = 'the start is outside of the map'
    GOAL_OUTSIDE = 'the goal is outside of the map'
    START_BLOCKED = 'the start is in an obstacle or too near to one'
    GOAL_BLOCKED = 'the goal is in an obstacle or too near to one'
    UNREACHABLE = 'obstacles block every path'
    GAVE_UP = 'the reward rule did not reach the goal'


def check_endpoints(
    blocked: NDArray[np.bool_ | np.uint8], start: tuple[int, int], goal: tuple[int, int], cost_max: int = 0
) -> NoRoute | None:
    """Return why no route can start or end at these cells, or None.

    The grid, shape (rows, columns), holds blocked cells, or costs of which those above ``cost_max`` are blocked.
    """
    rows, columns = blocked.shape
    ends = ((goal, NoRoute.GOAL_OUTSIDE, NoRoute.GOAL_BLOCKED), (start, NoRoute.START_OUTSIDE, NoRoute.START_BLOCKED))
    for (row, column), outside, inside in ends:
        if not (0 <= row < rows and 0 <= column < columns):
            return outside
        if blocked[row, column] > cost_max:
            return inside
    return None


@njit(cache=True)
def octile_distance(row_a: int, column_a: int, row_b: int, column_b: int) -> int:
    """Return the octile distance between two cells [1/STRAIGHT cells]."""
    rows, columns = abs(row_a - row_b), abs(column_a - column_b)
    if rows < columns:
        rows, columns = columns, rows
    return STRAIGHT * (rows - columns) + DIAGONAL * columns


def route_length(cells: NDArray[np.int64]) -> float:
    """Return the length of a route of neighbouring cells (rows and columns, shape (n, 2)) [cells]."""
    diagonal = int((np.diff(cells, axis=0) != 0).all(axis=1).sum())
    return len(cells) - 1 - diagonal + diagonal * math.sqrt(2.0)


def is_reachable(blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int]) -> bool:
    """Return whether a route that cuts no corner leads between two free cells of a grid, shape (rows, columns).

    A diagonal step needs both adjacent cells free, so connected cells are connected by straight steps.
    """
    _, components = cv2.connectedComponents((~blocked).view(np.uint8), connectivity=4)
    return bool(components[start] == components[goal])


_ROUNDING = 1e-5  # clearances are computed in single precision [m]


def travel_costs(costs: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return costs for a search whose multiplier is `HIDDEN_FACTOR` times as large, same shape.

    So the greatest cost, that of what obstacles hide, counts so many times as much: there the robot may be unable to
    see what it meets. Other costs count as before.
    """
    return np.where(costs < COST_MAX, np.rint(costs / HIDDEN_FACTOR), costs).astype(np.uint8)


def inflation_costs(
    clearance: NDArray[np.float32], inscribed_radius: float, settings: PlannerSettings
) -> NDArray[np.uint8]:
    """Return costs by the distance d from the nearest obstacle [m], same shape.

    They are `LETHAL` up to the inscribed radius r [m], 252 exp(-k (d - r)) up to inflation_radius with
    k = cost_scaling_factor, and 0 beyond or if k is 0.
    """
    costs = np.zeros(clearance.shape, dtype=np.uint8)
    if settings.cost_scaling_factor > 0.0:
        is_near = clearance <= settings.inflation_radius + _ROUNDING
        distances = clearance[is_near] - np.float32(inscribed_radius)
        costs[is_near] = np.rint(COST_MAX * np.exp(-settings.cost_scaling_factor * np.maximum(distances, 0.0)))
    costs[clearance <= inscribed_radius + _ROUNDING] = LETHAL
    return costs
