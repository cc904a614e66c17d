"""Confirmation of received lamp IDs."""

from __future__ import annotations


class IdConfirmation:
    """Confirms an ID after two equal consecutive ID packets of one lamp."""

    def __init__(self) -> None:
        """Start without packets."""
        self._last: int | None = None

    def add(self, beacon: int) -> int | None:
        """Add the ID of one packet and return the confirmed ID, None while it is unconfirmed."""
        confirmed = beacon if beacon == self._last else None
        self._last = beacon
        return confirmed
