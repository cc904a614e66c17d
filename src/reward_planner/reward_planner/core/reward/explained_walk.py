"""The rewards of the eight steps at each cell of a path of the reward rule."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.reward.reward_settings import RewardSettings
from reward_planner.core.reward.reward_walk import RewardWalk
from reward_planner.core.reward.step_reward import StepReward


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
