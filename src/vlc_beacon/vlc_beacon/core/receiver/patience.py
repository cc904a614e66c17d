"""When to stop listening to a lamp that tells nothing: a lamp on the mains flickers for ever."""

from __future__ import annotations

REST = 60.0
"""A lamp is left alone for so long [s]; then it is listened to again, for it may have been switched on."""


class Patience:
    """Listens and rests in turn while nothing is heard.

    Args:
        seconds: for how long to listen [s].
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._since: float | None = None
        self._has_listened = False

    @property
    def is_over(self) -> bool:
        """Whether the lamp was listened to in vain since it last told something."""
        return self._has_listened

    def listens(self, stamp: float) -> bool:
        """Return whether to listen at a time [s]."""
        if self._since is None or stamp < self._since or stamp >= self._since + self._seconds + REST:
            self._since = stamp
        self._has_listened |= stamp >= self._since + self._seconds
        return stamp < self._since + self._seconds

    def hear(self, stamp: float) -> None:
        """Take that the lamp told something [s]."""
        self._since, self._has_listened = stamp, False
