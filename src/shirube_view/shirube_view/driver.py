"""Dead man's switch: one page drives, and the robot stops when that page is silent."""

from collections.abc import Hashable
from threading import Lock

_ZERO_TIME = 0.5  # zero velocities are repeated for this long after a drive, then the topic is free for others [s]


class Driver:
    """Velocity of the page that drives; may be used from several threads."""

    def __init__(self, timeout: float) -> None:
        """Set the timeout of the heartbeat [s]."""
        self._timeout, self._lock = timeout, Lock()
        self._owner: Hashable = None
        self._velocity, self._heard, self._ended = (0.0, 0.0), -1e9, -1e9

    def drive(self, page: Hashable, forward: float, turn: float, now: float) -> str:
        """Set the velocity, as fractions of the greatest; return why the page must not drive, else an empty text."""
        with self._lock:
            if self._owner not in (None, page) and now - self._heard <= self._timeout:
                return 'another page drives; wait until its driver lets go'
            self._owner, self._velocity, self._heard = page, (forward, turn), now
            return ''

    def release(self, page: Hashable, now: float) -> None:
        """Stop if this page drives."""
        with self._lock:
            if page == self._owner:
                self._end(now)

    def velocity(self, now: float) -> tuple[float, float] | None:
        """Return what to publish, None if nobody has driven for a while."""
        with self._lock:
            if self._owner is not None and now - self._heard > self._timeout:
                self._end(now)
            if self._owner is not None:
                return self._velocity
            return (0.0, 0.0) if now - self._ended <= _ZERO_TIME else None

    def _end(self, now: float) -> None:
        self._owner, self._velocity, self._ended = None, (0.0, 0.0), now
