"""Why the reward rule goes as it goes: at each cell of the way the eight steps with their rewards."""

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
    """One cell of the way.

    Attributes:
        cell: row and column.
        rewards: of the eight steps from there, the best first.
        taken: rows and columns of the step that was taken; not always the best one, see `virtual_search`.
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
    """Yield the cells of a walk by the rule on a map as it is known.

    Args:
        blocked: shape (rows, columns), the cells that the robot cannot enter.
        start: row and column.
        goal: row and column.
        settings: of the rule.
        steps: how many to explain at most.
    """
    walk = RewardWalk(blocked.shape, start, goal, settings)
    for _ in range(steps):
        before, rewards = walk.cell, walk.explain(blocked)
        if walk.is_at_goal or not walk.advance(blocked):
            return
        taken = (walk.cell[0] - before[0], walk.cell[1] - before[1])
        yield ExplainedCell(before, rewards, taken)
