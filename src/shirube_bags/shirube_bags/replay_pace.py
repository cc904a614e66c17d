"""When the messages of a bag are due."""

from __future__ import annotations

from shirube_bags.stamps import NANOSECONDS


class ReplayPace:
    """Maps the bag's time to a steady clock's.

    A replay that fell behind, because the machine was busy or the program was halted, does not hurry:
    receivers with short queues would lose what comes in a burst. The rest is shifted instead.
    """

    # A late wake-up as any scheduler has it is caught up with [s].
    HARMLESS_DELAY = 0.02

    def __init__(self, rate: float, first_stamp_ns: int, now: float) -> None:
        """Begin.

        Args:
            rate: seconds of the bag a second; 0 makes every message due at once.
            first_stamp_ns: the bag's time at which the replay begins [ns].
            now: the steady clock's [s].
        """
        self._rate = rate
        self._first_stamp_ns = first_stamp_ns
        self._began = now

    def delay(self, stamp_ns: int, now: float) -> float:
        """Return how long to wait for the message with this stamp [s], 0 or more."""
        if self._rate == 0.0:
            return 0.0
        due = self._began + (stamp_ns - self._first_stamp_ns) / NANOSECONDS / self._rate
        if now - due > self.HARMLESS_DELAY:
            self._began += now - due
        return max(0.0, due - now)

    def bag_time(self, now: float) -> int:
        """Return the bag's time [ns] at a time of the steady clock [s]."""
        return self._first_stamp_ns + round((now - self._began) * self._rate * NANOSECONDS)
