"""Pose buffer: the robot's pose at the stamp of a frame, interpolated between received poses."""

from __future__ import annotations

import bisect
import math
from enum import Enum

from reward_planner.core.mapping.mapping_settings import MappingSettings
from shirube_core.geometry import SE2, wrap_angle

_HISTORY = 10.0  # length of the buffer [s]
_POSES_MAX = 5000
_POSE_NOISE = (0.3, 0.3)  # difference of poses that is not counted as motion [m, rad]


class PoseStatus(Enum):
    """Outcome of adding a pose."""

    ACCEPTED = 'accepted'
    NOT_FINITE = 'the pose is not finite'
    OUT_OF_ORDER = 'the pose is older than the previous one'
    JUMPED = 'the pose jumped; mapping waits until poses are consistent'
    RELOCATED = 'poses are consistent again after a jump'


class NoPoseReason(Enum):
    """Why there is no pose at a stamp."""

    NOT_YET = 'no pose as late as the frame yet'
    MISSING = 'no poses around the stamp of the frame'


class PoseBuffer:
    """Recent poses of the robot, checked for jumps."""

    def __init__(self, settings: MappingSettings) -> None:
        """Start without poses."""
        self._settings = settings
        self._stamps: list[float] = []
        self._poses: list[SE2] = []
        self._relocation: list[tuple[float, SE2]] = []

    @property
    def has_jumped(self) -> bool:
        """Whether poses jumped and are not yet consistent at the new place: the robot should stop."""
        return bool(self._relocation)

    def add(self, stamp: float, T_map_base: SE2) -> PoseStatus:
        """Add a pose and return its status; make a new buffer when the clock jumps back.

        Args:
            stamp: stamp of the pose [s].
            T_map_base: pose of the robot.
        """
        if not all(math.isfinite(v) for v in (stamp, T_map_base.x, T_map_base.y, T_map_base.yaw)):
            return PoseStatus.NOT_FINITE
        if stamp <= self._newest_stamp():
            return PoseStatus.OUT_OF_ORDER
        if not self._poses or self._is_plausible(stamp, T_map_base, self._stamps[-1], self._poses[-1]):
            self._relocation.clear()
            self._append(stamp, T_map_base)
            return PoseStatus.ACCEPTED
        return self._confirm_relocation(stamp, T_map_base)

    def lookup(self, stamp: float) -> SE2 | NoPoseReason:
        """Return the pose at a stamp [s], interpolated between its neighbours."""
        if not self._stamps or stamp > self._stamps[-1]:
            return NoPoseReason.NOT_YET
        after = bisect.bisect_left(self._stamps, stamp)
        if self._stamps[after] == stamp:
            return self._poses[after]
        if after == 0 or self._stamps[after] - self._stamps[after - 1] > self._settings.pose_gap_max:
            return NoPoseReason.MISSING
        return self._interpolate(after, stamp)

    def _interpolate(self, after: int, stamp: float) -> SE2:
        start, end = self._poses[after - 1], self._poses[after]
        fraction = (stamp - self._stamps[after - 1]) / (self._stamps[after] - self._stamps[after - 1])
        return SE2(
            start.x + fraction * (end.x - start.x),
            start.y + fraction * (end.y - start.y),
            wrap_angle(start.yaw + fraction * start.yaw_to(end)),
        )

    def _newest_stamp(self) -> float:
        if self._relocation:
            return self._relocation[-1][0]
        return self._stamps[-1] if self._stamps else -math.inf

    def _is_plausible(self, stamp: float, pose: SE2, last_stamp: float, last: SE2) -> bool:
        elapsed = min(stamp - last_stamp, self._settings.pose_gap_max)
        return (
            pose.distance_to(last) <= _POSE_NOISE[0] + elapsed * self._settings.speed_max
            and abs(pose.yaw_to(last)) <= _POSE_NOISE[1] + elapsed * self._settings.turn_rate_max
        )

    def _confirm_relocation(self, stamp: float, pose: SE2) -> PoseStatus:
        """Collect poses at a new place until they have been consistent for settle_time."""
        if self._relocation and not self._is_plausible(stamp, pose, *self._relocation[-1]):
            self._relocation.clear()
        self._relocation.append((stamp, pose))
        if stamp - self._relocation[0][0] < self._settings.settle_time:
            return PoseStatus.JUMPED
        self._restart(stamp, pose)
        return PoseStatus.RELOCATED

    def _restart(self, stamp: float, pose: SE2) -> None:
        self._relocation.clear()
        self._stamps, self._poses = [stamp], [pose]

    def _append(self, stamp: float, pose: SE2) -> None:
        self._stamps.append(stamp)
        self._poses.append(pose)
        old = bisect.bisect_left(self._stamps, stamp - _HISTORY)
        old = max(old, len(self._stamps) - _POSES_MAX)
        del self._stamps[:old], self._poses[:old]
