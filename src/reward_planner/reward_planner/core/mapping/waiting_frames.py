"""Frames that wait for the pose of their instant, and are dropped and counted if it does not come."""

from __future__ import annotations

from collections import Counter, deque
from enum import Enum
from typing import Generic, TypeVar

from reward_planner.core.mapping.pose_trail import NoPose, PoseTrail
from shirube_geometry import PlanarPose

_FRAMES_MAX = 32

Frame = TypeVar('Frame')


class DropReason(Enum):
    """Why a frame was dropped."""

    POSE_LATE = 'its pose did not come in time'
    POSE_MISSING = 'there are no poses around its time'
    TOO_MANY = 'too many frames waited'
    TIME_BACK = 'time jumped back'


class WaitingFrames(Generic[Frame]):
    """A short queue of frames.

    Attributes:
        dropped: number of frames by reason.
    """

    def __init__(self, wait: float) -> None:
        """Begin without frames.

        Args:
            wait: how long a frame waits for its pose [s].
        """
        self.dropped: Counter[DropReason] = Counter()
        self._wait = wait
        self._frames: deque[tuple[float, float, Frame]] = deque()

    def __len__(self) -> int:
        """Frames that wait."""
        return len(self._frames)

    def put(self, stamp: float, now: float, frame: Frame) -> None:
        """Take a frame with its stamp, and the time at which it came [s]."""
        if len(self._frames) == _FRAMES_MAX:
            self._frames.popleft()
            self.dropped[DropReason.TOO_MANY] += 1
        self._frames.append((stamp, now, frame))

    def take(self, now: float, trail: PoseTrail) -> list[tuple[float, Frame, PlanarPose]]:
        """Return the frames whose pose is known and drop those that waited in vain.

        Args:
            now: the time of the clock that `put` was told [s].
            trail: of the poses so far.

        Returns:
            stamp [s], frame and pose at the stamp, the oldest first.
        """
        ready = []
        waiting: deque[tuple[float, float, Frame]] = deque()
        for stamp, came, frame in self._frames:
            pose = trail.at(stamp)
            if isinstance(pose, PlanarPose):
                ready.append((stamp, frame, pose))
            elif pose is NoPose.MISSING:
                self.dropped[DropReason.POSE_MISSING] += 1
            elif not 0.0 <= now - came <= self._wait:
                self.dropped[DropReason.POSE_LATE] += 1
            else:
                waiting.append((stamp, came, frame))
        self._frames = waiting
        return ready
