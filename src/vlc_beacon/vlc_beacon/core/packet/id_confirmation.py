"""When a lamp's ID is believed."""

from __future__ import annotations


class IdConfirmation:
    """Believes an ID after two equal ID packets of one lamp, one right after the other."""

    def __init__(self) -> None:
        """Begin without packets."""
        self._last: int | None = None

    def add(self, beacon: int) -> int | None:
        """Take the ID of one packet and return the ID that is confirmed by it, None while there is none."""
        confirmed = beacon if beacon == self._last else None
        self._last = beacon
        return confirmed
