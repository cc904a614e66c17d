"""The reward rule step by step, on a map that may change between steps.

The rewards of the eight steps at each cell of a path of the reward rule.

Planning by the reward rule on the current map.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.planner_settings import RewardSettings
from reward_planner.core.reward.step_reward import (
    STEPS,
    StepReward,
    explain_steps,
    straight_step,
    write_step_terms,
)
from reward_planner.core.reward.virtual_search import choose_step
from reward_planner.core.route.route import NoRoute, NoRouteReason, Route, route_length
from reward_planner.core.route.shortest_route import shortest_route


class RewardWalk:
    """A robot that moves by the reward rule (section 2.3).

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
        self._goal = goal
        self._settings = settings
        self._reward_values = settings.table.reward_values()
        self._counted = settings.visits == 'counted'
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
        return self.cell == self._goal

    def explain(self, blocked: NDArray[np.bool_]) -> list[StepReward]:
        """Return the eight steps from the current cell by falling reward; ``blocked`` as for `advance`."""
        terms = np.empty((8, 5))
        arguments = (self._state, self._goal, self._reward_values, self._counted)
        write_step_terms(blocked, self._visits, *arguments, terms)
        return explain_steps(terms)

    def advance(self, blocked: NDArray[np.bool_]) -> bool:
        """Take the step that the rule chooses; return whether there was one.

        Args:
            blocked: cells known to be occupied, shape (rows, columns).
        """
        arguments = (self._state, self._goal, self._reward_values, self._counted)
        step = choose_step(blocked, self._visits, *arguments, self._settings.virtual_steps_max)
        if step < 0:
            return False
        row, column, _ = self._state
        went_straight = step == straight_step(row, column, self._goal)
        self._state = (row + int(STEPS[step, 0]), column + int(STEPS[step, 1]), went_straight)
        self._visits[self.cell] += 1
        return True


@dataclass(frozen=True)
class ExplainedCell:
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
    blocked: NDArray[np.bool_],
    start: tuple[int, int],
    goal: tuple[int, int],
    settings: RewardSettings,
    steps: int,
) -> Iterator[ExplainedCell]:
    """Yield the cells of a path of the reward rule on the current map.

    Args:
        blocked: cells that the robot cannot enter, shape (rows, columns).
        start: row and column of the start.
        goal: row and column of the goal.
        settings: settings of the reward rule.
        steps: maximum number of steps.
    """
    walk = RewardWalk(blocked.shape, start, goal, settings)
    for _ in range(steps):
        before, rewards = walk.cell, walk.explain(blocked)
        if walk.is_at_goal or not walk.advance(blocked):
            return
        taken = (walk.cell[0] - before[0], walk.cell[1] - before[1])
        yield ExplainedCell(before, rewards, taken)


_DETOUR_MAX = 20  # give up after this multiple of the shortest route


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
    shortest = shortest_route(blocked, start, goal)
    if isinstance(shortest, NoRoute):
        return shortest
    walk = RewardWalk(blocked.shape, start, goal, settings, visited_cells)
    total_steps_max = _DETOUR_MAX * min(len(shortest.cells), steps_max or len(shortest.cells))
    cells, steps = [start], 0
    while not walk.is_at_goal and (steps_max is None or len(cells) <= steps_max):
        steps += 1
        if steps > total_steps_max or not walk.advance(blocked):
            return NoRoute(NoRouteReason.GAVE_UP)
        if steps_max is not None and walk.cell in cells:
            del cells[cells.index(walk.cell) :]
        cells.append(walk.cell)
    path = np.array(cells, dtype=np.int64)
    return Route(path, route_length(path))
