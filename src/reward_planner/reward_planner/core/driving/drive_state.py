"""States and output of the drive controller."""

from dataclasses import dataclass
from enum import Enum

from reward_planner.core.driving.velocity_smoother import Velocity


class DriveState(Enum):
    """State of the drive controller."""

    IDLE = 'no goal'
    DRIVING = 'driving to the goal'
    LOOKING_AROUND = 'looking around'
    TURNING = 'turning on command of a lamp'
    STOPPED_BY_LAMP = 'stopped on command of a lamp'
    GOAL_REACHED = 'goal reached'
    UNREACHABLE = 'no path to the goal'
    LOST = 'no valid pose'
    MAP_STALE = 'the map is out of date'
    STUCK = 'stuck'
    PLANNING = 'planning'
    RECOVERING = 'recovering'
    GIVING_WAY = 'giving way to a moving obstacle'
    WAITING = 'waiting for a moving obstacle'
    GOING_AROUND = 'going around a moving obstacle'

    @property
    def needs_attention(self) -> bool:
        """Whether the robot is stopped by a problem that somebody must look at."""
        return self in (DriveState.UNREACHABLE, DriveState.LOST, DriveState.MAP_STALE, DriveState.STUCK)


@dataclass(frozen=True)
class DriveCommand:
    """Output of one control cycle.

    Attributes:
        state: state of the controller.
        detail: reason, one line for logs and diagnostics.
        velocity: velocity command; None leaves cmd_vel to other nodes.
        waypoint_map: lookahead point (x, y) [m], None if there is none.
    """

    state: DriveState
    detail: str
    velocity: Velocity | None
    waypoint_map: tuple[float, float] | None = None


def stop_command(state: DriveState, detail: str = '') -> DriveCommand:
    """Return the command to stop, with the state and its detail."""
    return DriveCommand(state, detail or state.value, Velocity())
