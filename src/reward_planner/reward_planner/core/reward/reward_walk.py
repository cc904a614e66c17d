"""The reward rule step by step, on a map that may change between steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.reward.step_reward import (
    STEPS,
    StepReward,
    explain_steps,
    straight_step,
    write_step_terms,
)
from reward_planner.core.reward.virtual_search import choose_step


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
