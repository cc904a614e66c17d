"""What a command can ask for."""

from enum import IntEnum


class Operation(IntEnum):
    """Operations by their number in the packet. Speeds are in m/s, angles in rad, counterclockwise."""

    STOP = 1
    """Stop and stay; no value."""
    RESUME = 2
    """Go on as if no light had spoken; no value."""
    SLOW = 3
    """Drive no faster than the value."""
    SPEED_UP = 4
    """Drive as fast as the value, or as the speed limit where that is lower."""
    TURN = 5
    """Turn on the spot by the value."""

    @property
    def word(self) -> str:
        """The operation as topics and files call it."""
        return self.name.lower()
