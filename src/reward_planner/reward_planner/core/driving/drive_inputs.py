"""The pose and the age of the map that the drive controller works with."""

import math

from reward_planner.core.driving.drive_state import DriveCommand, DriveState, stop_command
from reward_planner.core.driving.driving_settings import DrivingSettings
from shirube_core.geometry import SE2


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
