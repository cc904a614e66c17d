"""Message filter: holds frames until the pose at their stamp is known, and counts dropped ones."""

from __future__ import annotations

from collections import Counter, deque
from enum import Enum
from typing import Generic, TypeVar

from reward_planner.core.mapping.pose_buffer import PoseBuffer
from shirube_core.geometry import SE2
from shirube_core.motion import NoPoseReason

_FRAMES_MAX = 32

Frame = TypeVar('Frame')


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
