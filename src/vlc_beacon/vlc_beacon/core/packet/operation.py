"""Operations of commands."""

from enum import IntEnum


class Operation(IntEnum):
    """Operation codes of the packet. Speeds are in m/s, angles in rad, counterclockwise."""

    STOP = 1
    """Stop until resume; no value."""
    RESUME = 2
    """Resume driving at the cruise speed; no value."""
    SLOW = 3
    """Limit the speed to the value."""
    SPEED_UP = 4
    """Set the speed to the value, bounded by the speed limit."""
    TURN = 5
    """Turn in place by the value."""

    @property
    def label(self) -> str:
        """Name of the operation in topics and files."""
        return self.name.lower()
