"""Settings of the planner, and of the paper's reward rule."""

from dataclasses import astuple, dataclass, field

import numpy as np
from numpy.typing import NDArray

from reward_planner.core.safety.footprint import Footprint
from shirube_core.settings import setting, tunable


@tunable()
@dataclass(frozen=True)
class PlannerSettings:
    """Planning mode, shape of the robot and costs of routes."""

    mode: str = setting(
        'optimal',
        "planning mode: the route of least cost, or the paper's reward rule (without costs)",
        choices=('optimal', 'reward'),
    )
    robot_radius: float = setting(
        0.2, 'radius of the circle around the robot; its centre keeps farther from obstacles', 'm', (0.0, 10.0)
    )
    footprint: tuple[float, ...] = setting(
        (),
        'corners of the robot in base_frame, as in collision_monitor: x, y of the first, x, y of the second ...; empty '
        'takes the circle of robot_radius, which the greatest circle around base_frame in the footprint replaces else',
        'm',
        (-10.0, 10.0),
    )
    inflation_radius: float = setting(
        0.55,
        'routes cost more up to this distance from obstacles; without effect below robot_radius + clearance_margin',
        'm',
        (0.0, 10.0),
    )
    cost_scaling_factor: float = setting(
        3.0,
        'decay k of the cost exp(-k (d - robot_radius - clearance_margin)) at a distance d from obstacles; 0 disables '
        'costs: the shortest route',
        '1/m',
        (0.0, 100.0),
    )
    cost_travel_multiplier: float = setting(
        2.0, 'a metre at the greatest cost counts as so many metres more', limits=(0.0, 100.0)
    )
    unknown: str = setting('free', 'whether routes may enter unknown cells', choices=('free', 'blocked'))


@tunable()
@dataclass(frozen=True)
class RewardTable:
    """Table 1 of the paper: rewards and penalties of one step, in the rows of the table."""

    advance: float = setting(100.0, 'row 1: a free step earns this/L - L, L cells from the goal', limits=(0.0, 1e6))
    collision: float = setting(-1000.0, 'row 2: the step hits an obstacle', limits=(-1e6, 0.0))
    outside: float = setting(-1000.0, 'row 3: the step leaves the map', limits=(-1e6, 0.0))
    visited: float = setting(-250.0, 'row 4: the step enters a visited cell', limits=(-1e6, 0.0))
    detour: float = setting(
        -100.0, 'row 5: neither this step nor the last one goes straight to the goal', limits=(-1e6, 0.0)
    )

    def reward_values(self) -> NDArray[np.float64]:
        """Return the rows as an array for numba kernels, shape (5,)."""
        return np.array(astuple(self), dtype=np.float64)


@tunable()
@dataclass(frozen=True)
class RewardSettings:
    """Penalties, virtual search and the reward table."""

    visits: str = setting(
        'once',
        'penalty of a visited cell: once, as in the paper, or counted for each visit',
        choices=('once', 'counted'),
    )
    virtual_steps_max: int = setting(
        5000, 'maximum number of steps of the virtual search; 0 disables it', limits=(0, 10_000_000)
    )
    table: RewardTable = field(default_factory=RewardTable)


def check_planner_settings(planner: PlannerSettings) -> None:
    """Raise a RewardPlannerError if the footprint is no polygon around the base frame's origin."""
    if planner.footprint:
        _ = Footprint(planner.footprint, planner.robot_radius).inscribed_radius
