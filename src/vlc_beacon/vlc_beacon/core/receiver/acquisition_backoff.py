"""Acquisition back-off for lamps without packets, such as mains lamps, which flicker permanently."""

from __future__ import annotations

BACKOFF_TIME = 60.0
"""Pause between acquisition attempts [s]."""


class AcquisitionBackoff:
    """Alternates between acquisition and pause while no packet is received.

    Args:
        seconds: duration of an acquisition attempt [s].
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._since: float | None = None
        self._has_timed_out = False

    @property
    def has_timed_out(self) -> bool:
        """Whether an acquisition attempt has timed out since the last packet."""
        return self._has_timed_out

    def is_active(self, stamp: float) -> bool:
        """Return whether to decode the lamp at a time [s]."""
        if self._since is None or stamp < self._since or stamp >= self._since + self._seconds + BACKOFF_TIME:
            self._since = stamp
        self._has_timed_out |= stamp >= self._since + self._seconds
        return stamp < self._since + self._seconds

    def reset(self, stamp: float) -> None:
        """Restart the timeout after a received packet [s]."""
        self._since, self._has_timed_out = stamp, False
