"""States and output of the drive controller."""

import math
from dataclasses import dataclass
from enum import Enum

from reward_planner.core.driving.velocity_smoother import Velocity
from reward_planner.core.settings import DrivingSettings
from shirube_core.geometry import SE2


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


class DriveInputs:
    """Latest pose and map.

    Attributes:
        pose: the robot's pose in the map; None before the first one and while poses jump.
        pose_stamp: stamp of the pose [s].
        map_stamp: stamp of the latest frame in the map [s].
    """

    def __init__(self) -> None:
        """Start without pose and map."""
        self.pose: SE2 | None = None
        self.pose_stamp = self.map_stamp = -math.inf

    def stale(self, now: float, settings: DrivingSettings) -> DriveCommand | None:
        """Return a stop with its reason if pose or map is missing or stale at a time [s], else None."""
        if self.pose is None:
            detail = 'no pose received' if self.pose_stamp == -math.inf else 'the pose jumped'
            return stop_command(DriveState.LOST, f'{DriveState.LOST.value}: {detail}')
        for state, stamp, limit, what in (
            (DriveState.LOST, self.pose_stamp, settings.pose_timeout, 'pose'),
            (DriveState.MAP_STALE, self.map_stamp, settings.map_timeout, 'frame'),
        ):
            if not abs(now - stamp) <= limit:
                age = f'the latest {what} is older than {limit:g} s or in the future'
                why = age if stamp > -math.inf else f'no {what} received'
                return stop_command(state, f'{state.value}: {why}')
        return None
