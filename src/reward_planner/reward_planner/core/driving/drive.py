"""What the robot does, and why."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from reward_planner.core.driving.velocity_ramp import Velocity


class DriveState(Enum):
    """What the robot does."""

    IDLE = 'no goal'
    DRIVING = 'on the way'
    TURNING = 'turning as a lamp said'
    HELD = 'a lamp said stop'
    REACHED = 'goal reached'
    UNREACHABLE = 'no way to the goal'
    LOST = 'the pose is not known'
    BLIND = 'the map is not up to date'
    STUCK = 'cannot go on'

    @property
    def needs_people(self) -> bool:
        """Whether the robot stands although it should not."""
        return self in (DriveState.UNREACHABLE, DriveState.LOST, DriveState.BLIND, DriveState.STUCK)


@dataclass(frozen=True)
class Drive:
    """What is to be done now.

    Attributes:
        state: what the robot does.
        detail: one line for people.
        velocity: to be sent to the motors; None leaves them to others.
        waypoint_map: shape (2,) as a tuple, the point it heads for [m]; None where there is none.
    """

    state: DriveState
    detail: str
    velocity: Velocity | None
    waypoint_map: tuple[float, float] | None = None
