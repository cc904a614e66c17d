"""Settings of the reward rule."""

from __future__ import annotations

from dataclasses import dataclass, field

from reward_planner.core.reward.reward_table import RewardTable
from shirube_core.settings import setting


@dataclass(frozen=True)
class RewardSettings:
    """Penalties, virtual search and the reward table."""

    visits: str = setting(
        'once',
        'penalty of a visited cell: once, as in the paper, or counted for each visit',
        choices=('once', 'counted'),
    )
    virtual_steps_max: int = setting(
        5000,
        'maximum number of steps of the virtual search; 0 disables it',
        minimum=0,
        maximum=10_000_000,
    )
    table: RewardTable = field(default_factory=RewardTable)
