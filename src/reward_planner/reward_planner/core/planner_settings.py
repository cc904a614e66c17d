"""How routes are planned."""

from __future__ import annotations

from dataclasses import dataclass

from shirube_settings import setting


@dataclass(frozen=True)
class PlannerSettings:
    """Routes for a robot of some size."""

    mode: str = setting(
        'optimal', "the shortest route, or the way of the paper's reward rule", choices=('optimal', 'reward')
    )
    robot_radius: float = setting(
        0.2,
        'of the circle around the robot; its centre keeps farther from obstacles',
        unit='m',
        minimum=0.0,
        maximum=10.0,
    )
