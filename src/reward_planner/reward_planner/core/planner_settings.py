"""Settings of the planner."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_core.settings import setting


@dataclass(frozen=True)
class PlannerSettings:
    """Planning mode and robot radius."""

    mode: str = setting(
        'optimal',
        "planning mode: the shortest route, or the paper's reward rule",
        choices=('optimal', 'reward'),
    )
    robot_radius: float = setting(
        0.2,
        'radius of the circle around the robot; its centre keeps farther from obstacles',
        unit='m',
        minimum=0.0,
        maximum=10.0,
    )
