"""When a lamp's ID is believed."""

from __future__ import annotations

from collections.abc import Set as AbstractSet


class IdConfirmation:
    """Believes an ID after two equal ID packets of one lamp, one right after the other.

    Args:
        known: the IDs there are; others count as damage.
    """

    def __init__(self, known: AbstractSet[int]) -> None:
        self._known = frozenset(known)
        self._last: int | None = None

    def add(self, beacon: int) -> int | None:
        """Take the ID of one packet and return the ID that is confirmed by it, None while there is none."""
        confirmed = beacon if beacon == self._last and beacon in self._known else None
        self._last = beacon
        return confirmed
