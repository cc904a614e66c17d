"""Rewards of the eight steps of a robot, by the rows of Table 1."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.settings import RewardTable

ADVANCE, COLLISION, OUTSIDE, VISITED, DETOUR = range(5)
TERM_NAMES = tuple(row.name for row in fields(RewardTable))

STEPS = np.array([(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)])

_AT_GOAL = 0.5  # L of a step that ends at the goal: nearer than any other cell, and 100/L is finite


class RewardRule(NamedTuple):
    """The reward rule to one goal, for numba kernels.

    Attributes:
        goal: row and column of the goal.
        values: rows of Table 1, shape (5,).
        is_counted: whether row 4 applies for each visit.
    """

    goal: tuple[int, int]
    values: NDArray[np.float64]
    is_counted: bool


@dataclass(frozen=True)
class StepReward:
    """Reward of one step.

    Attributes:
        step: rows and columns, each -1, 0 or 1.
        terms: non-zero rewards by row of the table.
        total: sum of the rewards.
        can_enter: whether the step is possible; an occupied cell is never entered, whatever the total.
    """

    step: tuple[int, int]
    terms: dict[str, float]
    total: float
    can_enter: bool


def explain_steps(terms: NDArray[np.float64]) -> list[StepReward]:
    """Return the eight steps by falling reward; ``terms`` as `write_step_terms` computes them, shape (8, 5)."""
    order = np.argsort(-terms.sum(axis=1), kind='stable')
    return [
        StepReward(
            (int(STEPS[k, 0]), int(STEPS[k, 1])),
            {name: float(term) for name, term in zip(TERM_NAMES, terms[k], strict=True) if term},
            float(terms[k].sum()),
            can_enter(terms[k]),
        )
        for k in order
    ]


@njit(cache=True)
def can_enter(terms: NDArray[np.float64]) -> bool:
    """Return whether a step with these terms, shape (5,), is free and stays on the map."""
    return terms[COLLISION] == 0.0 and terms[OUTSIDE] == 0.0


@njit(cache=True)
def straight_step(row: int, column: int, goal: tuple[int, int]) -> int:
    """Return the number of the step that ends nearest to the goal, regardless of obstacles."""
    best, best_squared = 0, np.inf
    for k in range(8):
        squared = (row + STEPS[k, 0] - goal[0]) ** 2 + (column + STEPS[k, 1] - goal[1]) ** 2
        if squared < best_squared:
            best, best_squared = k, squared
    return best


@njit(cache=True)
def write_step_terms(
    rule: RewardRule,
    blocked: NDArray[np.bool_],
    visits: NDArray[np.int32],
    state: tuple[int, int, bool],
    terms: NDArray[np.float64],
) -> None:
    """Compute the rewards of the eight steps, by the rows of Table 1: ``terms``, shape (8, 5).

    ``blocked`` and the numbers of ``visits`` of each cell have the shape (rows, columns). The state is the robot's row
    and column, and whether its last step went straight to the goal. A step past a blocked corner is a collision.
    """
    row, column, went_straight = state
    straight = straight_step(row, column, rule.goal)
    terms[:] = 0.0
    for k in range(8):
        to_row, to_column = row + STEPS[k, 0], column + STEPS[k, 1]
        if not (0 <= to_row < blocked.shape[0] and 0 <= to_column < blocked.shape[1]):
            terms[k, OUTSIDE] = rule.values[OUTSIDE]
        elif blocked[to_row, to_column] or blocked[to_row, column] or blocked[row, to_column]:
            terms[k, COLLISION] = rule.values[COLLISION]
        else:
            L = max(np.hypot(to_row - rule.goal[0], to_column - rule.goal[1]), _AT_GOAL)
            terms[k, ADVANCE] = rule.values[ADVANCE] / L - L
            times = visits[to_row, to_column]
            terms[k, VISITED] = rule.values[VISITED] * (times if rule.is_counted else min(times, 1))
            if k != straight and not went_straight:
                terms[k, DETOUR] = rule.values[DETOUR]
