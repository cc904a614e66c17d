"""When to stop listening to a lamp that tells nothing: a lamp on the mains flickers for ever."""

from __future__ import annotations

LISTEN = 15.0
"""A lamp that tells nothing for so long is left alone [s]. Two IDs and two commands of 30 bit/s take 11 s."""
REST = 60.0
"""For so long [s]; then it is listened to again, for it may have been switched on."""


class Patience:
    """Listens and rests in turn while nothing is heard."""

    def __init__(self) -> None:
        """Begin with listening."""
        self._since: float | None = None
        self._has_listened = False

    @property
    def is_over(self) -> bool:
        """Whether the lamp was listened to in vain since it last told something."""
        return self._has_listened

    def listens(self, stamp: float) -> bool:
        """Return whether to listen at a time [s]."""
        if self._since is None or stamp < self._since or stamp >= self._since + LISTEN + REST:
            self._since = stamp
        self._has_listened |= stamp >= self._since + LISTEN
        return stamp < self._since + LISTEN

    def hear(self, stamp: float) -> None:
        """Take that the lamp told something [s]."""
        self._since, self._has_listened = stamp, False
