"""Zone rules executed on the current visit of each zone."""

from __future__ import annotations

import math
from collections.abc import Mapping

from vlc_beacon.core.packet.command_packet import Command

LEAVING = 1.25
"""Exit radius over zone radius: hysteresis for a robot at the border."""


class ZoneVisits:
    """Zones around beacons and the rules executed in them.

    Args:
        places: position x, y of each beacon in the map [m].
        radius: radius of the zones [m].
    """

    def __init__(self, places: Mapping[int, tuple[float, float]], radius: float) -> None:
        self._places = dict(places)
        self._radius = radius
        self._done: dict[int, set[tuple[int, int]]] = {}

    def robot_at(self, position: tuple[float, float]) -> None:
        """Update the robot's position [m] and end the visits of zones that it left."""
        leaving = LEAVING * self._radius
        self._done = {
            beacon: done
            for beacon, done in self._done.items()
            if math.dist(position, self._places[beacon]) <= leaving
        }

    def distance(self, beacon: int, position: tuple[float, float]) -> float | None:
        """Return the distance of a beacon from a position [m], or None for an unknown beacon."""
        return math.dist(position, self._places[beacon]) if beacon in self._places else None

    def is_within(self, distance: float) -> bool:
        """Return whether a distance from a beacon [m] is within its zone."""
        return distance <= self._radius

    def is_done(self, rule: Command) -> bool:
        """Return whether the rule was executed on this visit."""
        return (rule.counter, rule.operation) in self._done.get(rule.beacon, set())

    def add_done(self, rule: Command) -> None:
        """Mark the rule as executed."""
        self._done.setdefault(rule.beacon, set()).add((rule.counter, rule.operation))
