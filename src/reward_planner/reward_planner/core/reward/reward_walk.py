"""Walks and routes by the paper's reward rule (section 2.3)."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from reward_planner.core.reward.step_reward import (
    STEPS,
    RewardRule,
    StepReward,
    can_enter,
    explain_steps,
    straight_step,
    write_step_terms,
)
from reward_planner.core.route.route import DIAGONAL, STRAIGHT, NoRoute, Route
from reward_planner.core.route.shortest_route import shortest_route
from reward_planner.core.settings import RewardSettings


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


_DETOUR_MAX = 20  # give up after this multiple of the shortest route


class RewardWalk:
    """A robot that moves by the reward rule, on a map that may change between steps.

    Args:
        shape: rows and columns of the map.
        start: row and column of the start.
        goal: row and column of the goal.
        settings: settings of the reward rule.
        visited_cells: rows and columns of cells visited before, one entry for each visit, shape (n, 2).
    """

    def __init__(
        self,
        shape: tuple[int, int],
        start: tuple[int, int],
        goal: tuple[int, int],
        settings: RewardSettings,
        visited_cells: NDArray[np.int64] | None = None,
    ) -> None:
        # Step 0: the robot knows only its own cell and the goal.
        self._rule = RewardRule(goal, settings.table.reward_values(), settings.visits == 'counted')
        self._virtual_steps_max = settings.virtual_steps_max
        self._visits = np.zeros(shape, dtype=np.int32)
        if visited_cells is not None:
            np.add.at(self._visits, (visited_cells[:, 0], visited_cells[:, 1]), 1)
        self._visits[start] += 1
        self._state = (*start, True)

    @property
    def cell(self) -> tuple[int, int]:
        """Row and column of the robot's cell."""
        return self._state[:2]

    @property
    def is_at_goal(self) -> bool:
        """Whether the robot is at the goal."""
        return self.cell == self._rule.goal

    def advance(self, blocked: NDArray[np.bool_]) -> bool:
        """Take the step that the rule chooses; return whether there was one.

        Args:
            blocked: cells known to be occupied, shape (rows, columns): the map of step 1.
        """
        # Step 2: the rewards, or the virtual search, choose one of the eight steps.
        step = choose_step(self._rule, blocked, self._visits, self._state, self._virtual_steps_max)
        if step < 0:
            return False
        # The robot moves, and remembers for rows 4 and 5 of Table 1 where it was and whether it went straight.
        row, column, _ = self._state
        went_straight = step == straight_step(row, column, self._rule.goal)
        self._state = (row + int(STEPS[step, 0]), column + int(STEPS[step, 1]), went_straight)
        self._visits[self.cell] += 1
        return True

    def explain(self, blocked: NDArray[np.bool_]) -> list[StepReward]:
        """Return the eight steps from the current cell by falling reward; ``blocked`` as for `advance`."""
        terms = np.empty((8, 5))
        write_step_terms(self._rule, blocked, self._visits, self._state, terms)
        return explain_steps(terms)


class ExplainedCell(NamedTuple):
    """One cell of the path.

    Attributes:
        cell: row and column of the cell.
        rewards: rewards of the eight steps from the cell, the best first.
        taken: rows and columns of the step taken; not always the best one, see `virtual_search`.
    """

    cell: tuple[int, int]
    rewards: list[StepReward]
    taken: tuple[int, int]


def explained_walk(
    blocked: NDArray[np.bool_], start: tuple[int, int], goal: tuple[int, int], settings: RewardSettings, steps: int
) -> Iterator[ExplainedCell]:
    """Yield the cells of a path of at most so many steps by the reward rule; arguments as for `reward_route`."""
    walk = RewardWalk(blocked.shape, start, goal, settings)
    for _ in range(steps):
        before, rewards = walk.cell, walk.explain(blocked)
        if walk.is_at_goal or not walk.advance(blocked):
            return
        taken = (walk.cell[0] - before[0], walk.cell[1] - before[1])
        yield ExplainedCell(before, rewards, taken)


def reward_route(
    blocked: NDArray[np.bool_],
    start: tuple[int, int],
    goal: tuple[int, int],
    settings: RewardSettings,
    visited_cells: NDArray[np.int64] | None = None,
    steps_max: int | None = None,
) -> Route | NoRoute:
    """Plan a route by the reward rule.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns).
        start: row and column of the start.
        goal: row and column of the goal.
        settings: settings of the reward rule.
        visited_cells: cells that the robot visited before, shape (n, 2); the rule penalises them.
        steps_max: maximum number of steps of the route, from which loops are removed; None for the whole route to the
            goal, which may cross itself.
    """
    # The rule cannot detect that there is no path; a search does.
    shortest = shortest_route(blocked, start, goal)
    if isinstance(shortest, NoRoute):
        return shortest
    walk = RewardWalk(blocked.shape, start, goal, settings, visited_cells)
    total_steps_max = _DETOUR_MAX * min(len(shortest.cells), steps_max or len(shortest.cells))
    cells, steps = [start], 0
    # Step 3: repeat until the goal is reached.
    while not walk.is_at_goal and (steps_max is None or len(cells) <= steps_max):
        steps += 1
        if steps > total_steps_max or not walk.advance(blocked):
            return NoRoute.GAVE_UP
        if steps_max is not None and walk.cell in cells:
            del cells[cells.index(walk.cell) :]
        cells.append(walk.cell)
    return Route(np.array(cells, dtype=np.int64))
