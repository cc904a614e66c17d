"""Timing of a replay."""

from __future__ import annotations

from shirube_bags.stamps import NANOSECONDS


class ReplayClock:
    """Maps the time of the bag to a steady clock.

    A replay that fell behind, because of load or a suspended process, does not catch up: subscribers with short queues
    would lose messages of a burst. The remaining messages are delayed instead.
    """

    # A longer delay is not caught up; shorter ones are normal scheduling jitter [s].
    CATCH_UP_MAX = 0.02

    def __init__(self, rate: float, first_stamp_ns: int, now: float) -> None:
        """Start the replay.

        Args:
            rate: playback rate; 0 makes every message due at once.
            first_stamp_ns: time of the bag at the start of the replay [ns].
            now: time of the steady clock [s].
        """
        self._rate = rate
        self._first_stamp_ns = first_stamp_ns
        self._began = now

    def delay(self, stamp_ns: int, now: float) -> float:
        """Return the delay until a message is due [s], 0 or more."""
        if self._rate == 0.0:
            return 0.0
        due = self._began + (stamp_ns - self._first_stamp_ns) / NANOSECONDS / self._rate
        if now - due > self.CATCH_UP_MAX:
            self._began += now - due
        return max(0.0, due - now)

    def bag_time(self, now: float) -> int:
        """Return the time of the bag [ns] at a time of the steady clock [s]."""
        return self._first_stamp_ns + round((now - self._began) * self._rate * NANOSECONDS)
