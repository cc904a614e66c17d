"""Virtual search (section 2.3, step 2): if the straight step is not the best, simulate the two best steps.

From each of them the same rule is simulated on the current map until it reaches the goal; the step with the shorter
path is taken.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.reward.step_reward import STEPS, RewardRule, can_enter, straight_step, write_step_terms
from reward_planner.core.route.route import DIAGONAL, STRAIGHT


@njit(cache=True)
def choose_step(
    rule: RewardRule,
    blocked: NDArray[np.bool_],
    visits: NDArray[np.int32],
    state: tuple[int, int, bool],
    steps_max: int,
) -> int:
    """Return the number of the step to take, -1 for none; arguments as for `virtual_path_length`."""
    # Table 1 gives the rewards; of the possible steps the two with the highest sums are candidates.
    terms = np.empty((8, 5))
    write_step_terms(rule, blocked, visits, state, terms)
    first, second = best_steps(terms)
    # The best step is taken if it goes straight to the goal, as row 1 of the table expects.
    if steps_max == 0 or second < 0 or first == straight_step(state[0], state[1], rule.goal):
        return first
    # Otherwise the candidate with the shorter virtual path is taken (fig. 3, paths (a) and (b)).
    a = virtual_path_length(rule, blocked, visits, state, first, steps_max)
    b = virtual_path_length(rule, blocked, visits, state, second, steps_max)
    return second if b >= 0 and (b < a or a < 0) else first


@njit(cache=True)
def best_steps(terms: NDArray[np.float64]) -> tuple[int, int]:
    """Return the numbers of the two best possible steps, -1 for none; terms have shape (8, 5)."""
    first, second = -1, -1
    for k in range(8):
        if not can_enter(terms[k]):
            continue
        total = terms[k].sum()
        if first < 0 or total > terms[first].sum():
            first, second = k, first
        elif second < 0 or total > terms[second].sum():
            second = k
    return first, second


@njit(cache=True)
def virtual_path_length(
    rule: RewardRule,
    blocked: NDArray[np.bool_],
    visits: NDArray[np.int32],
    state: tuple[int, int, bool],
    first_step: int,
    steps_max: int,
) -> int:
    """Return the length of the simulated path to the goal, -1 if it does not reach it [1/STRAIGHT cells].

    The simulation starts with step number ``first_step`` and ends after ``steps_max`` steps; it counts visits, and
    restores them at its end. The other arguments are those of `write_step_terms`.
    """
    path = np.empty((steps_max, 2), np.int32)
    terms = np.empty((8, 5))
    goal = rule.goal
    row, column, went_straight = state
    step, length, count = first_step, 0, 0
    while step >= 0 and count < steps_max and not (row == goal[0] and column == goal[1]):
        went_straight = step == straight_step(row, column, goal)
        row, column = row + STEPS[step, 0], column + STEPS[step, 1]
        length += DIAGONAL if STEPS[step, 0] and STEPS[step, 1] else STRAIGHT
        visits[row, column] += 1
        path[count, 0], path[count, 1] = row, column
        count += 1
        write_step_terms(rule, blocked, visits, (row, column, went_straight), terms)
        step = best_steps(terms)[0]
    for k in range(count):
        visits[path[k, 0], path[k, 1]] -= 1
    return length if row == goal[0] and column == goal[1] else -1
