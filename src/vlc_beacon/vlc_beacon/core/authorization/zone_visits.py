"""Zone rules executed on the current visit of each zone."""

from __future__ import annotations

import math
from collections.abc import Mapping

from vlc_beacon.core.packet.command_packet import Command

EXIT_FACTOR = 1.25
"""Exit radius over zone radius: hysteresis for a robot at the border."""


class ZoneVisits:
    """Zones around beacons and the rules executed in them.

    Args:
        positions: position x, y of each beacon in the map [m].
        radius: radius of the zones [m].
    """

    def __init__(self, positions: Mapping[int, tuple[float, float]], radius: float) -> None:
        self._positions = dict(positions)
        self._radius = radius
        self._executed: dict[int, set[tuple[int, int]]] = {}

    def update_position(self, position: tuple[float, float]) -> None:
        """Update the robot's position [m] and end the visits of zones that it left."""
        leaving = EXIT_FACTOR * self._radius
        self._executed = {
            beacon: executed
            for beacon, executed in self._executed.items()
            if math.dist(position, self._positions[beacon]) <= leaving
        }

    def distance(self, beacon: int, position: tuple[float, float]) -> float | None:
        """Return the distance of a beacon from a position [m], or None for an unknown beacon."""
        return math.dist(position, self._positions[beacon]) if beacon in self._positions else None

    def is_within(self, distance: float) -> bool:
        """Return whether a distance from a beacon [m] is within its zone."""
        return distance <= self._radius

    def is_executed(self, command: Command) -> bool:
        """Return whether the rule was executed on this visit."""
        return (command.counter, command.operation) in self._executed.get(command.beacon, set())

    def mark_executed(self, command: Command) -> None:
        """Mark the rule as executed."""
        self._executed.setdefault(command.beacon, set()).add((command.counter, command.operation))
