"""How the reward rule is read where the paper leaves it open."""

from __future__ import annotations

from dataclasses import dataclass, field

from reward_planner.core.reward.reward_table import RewardTable
from shirube_settings import setting


@dataclass(frozen=True)
class RewardSettings:
    """The reward rule."""

    visits: str = setting(
        'once',
        'the penalty of a cell where the robot has been: once, as in the paper, or as often as it was there',
        choices=('once', 'counted'),
    )
    virtual_steps_max: int = setting(
        5000,
        'longest way that the virtual search follows; 0 leaves the search out',
        minimum=0,
        maximum=10_000_000,
    )
    table: RewardTable = field(default_factory=RewardTable)
