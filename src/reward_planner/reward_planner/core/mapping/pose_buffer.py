"""Pose buffer: poses interpolated at the stamps of frames, and the queue of frames that wait for theirs."""

import math
from collections import Counter, deque
from enum import Enum
from typing import Generic, TypeVar

from reward_planner.core.settings import MappingSettings
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason, OdometryBuffer

_HISTORY = 10_000_000_000  # length of the buffer [ns]
_POSE_NOISE = (0.3, 0.3)  # difference of poses that is not counted as motion [m, rad]
_FRAMES_MAX = 32

Frame = TypeVar('Frame')


class PoseStatus(Enum):
    """Outcome of adding a pose."""

    ACCEPTED = 'accepted'
    NOT_FINITE = 'the pose is not finite'
    OUT_OF_ORDER = 'the pose is older than the previous one'
    JUMPED = 'the pose jumped; mapping waits until poses are consistent'
    RELOCATED = 'poses are consistent again after a jump'


class PoseBuffer:
    """Recent poses of the robot, checked for jumps."""

    def __init__(self, settings: MappingSettings) -> None:
        """Start without poses."""
        self._settings = settings
        self._restart()

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
        if self._latest is None or self._is_plausible(stamp, T_map_base, *self._latest):
            self._relocation.clear()
            self._append(stamp, T_map_base)
            return PoseStatus.ACCEPTED
        return self._confirm_relocation(stamp, T_map_base)

    def pose_at(self, stamp: float) -> SE2 | NoPoseReason:
        """Return the pose at a stamp [s], interpolated between its neighbours."""
        return self._poses.pose_at(round(1e9 * stamp))

    def _newest_stamp(self) -> float:
        if self._relocation:
            return self._relocation[-1][0]
        return self._latest[0] if self._latest else -math.inf

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
        self._restart()
        self._append(stamp, pose)
        return PoseStatus.RELOCATED

    def _restart(self) -> None:
        gap_max = round(1e9 * self._settings.pose_gap_max)
        self._poses = OdometryBuffer(_HISTORY, gap_max, 0, math.inf, math.inf)
        self._latest: tuple[float, SE2] | None = None
        self._relocation: list[tuple[float, SE2]] = []

    def _append(self, stamp: float, pose: SE2) -> None:
        self._poses.add(round(1e9 * stamp), pose)
        self._latest = (stamp, pose)


class DropReason(Enum):
    """Why a frame was dropped."""

    POSE_LATE = 'no pose within pose_wait'
    POSE_MISSING = 'no poses around its stamp'
    QUEUE_FULL = 'queue full'
    TIME_JUMP = 'clock jumped back'


class PoseMessageFilter(Generic[Frame]):
    """A short queue of frames that wait for their pose, as tf2's message filter does.

    Attributes:
        dropped: number of dropped frames by reason.
    """

    def __init__(self, wait: float) -> None:
        """Start without frames.

        Args:
            wait: time after which a frame without a pose is dropped [s].
        """
        self.dropped: Counter[DropReason] = Counter()
        self._wait = wait
        self._frames: deque[tuple[float, float, Frame]] = deque()

    def __len__(self) -> int:
        """Number of queued frames."""
        return len(self._frames)

    def add(self, stamp: float, now: float, frame: Frame) -> None:
        """Queue a frame with its stamp and the time of its receipt [s]."""
        if len(self._frames) == _FRAMES_MAX:
            self._frames.popleft()
            self.dropped[DropReason.QUEUE_FULL] += 1
        self._frames.append((stamp, now, frame))

    def take_ready(self, now: float, buffer: PoseBuffer) -> list[tuple[float, Frame, SE2]]:
        """Return the frames whose pose is known and drop those that timed out.

        Args:
            now: current time, by the clock of `add` [s].
            buffer: poses received so far.

        Returns:
            stamp [s], frame and pose at the stamp, oldest first.
        """
        ready = []
        waiting: deque[tuple[float, float, Frame]] = deque()
        for stamp, received, frame in self._frames:
            pose = buffer.pose_at(stamp)
            if isinstance(pose, SE2):
                ready.append((stamp, frame, pose))
            elif pose in (NoPoseReason.TOO_OLD, NoPoseReason.GAP):
                self.dropped[DropReason.POSE_MISSING] += 1
            elif not 0.0 <= now - received <= self._wait:
                self.dropped[DropReason.POSE_LATE] += 1
            else:
                waiting.append((stamp, received, frame))
        self._frames = waiting
        return ready
