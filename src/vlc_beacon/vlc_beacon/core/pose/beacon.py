"""A lamp at a known place."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Beacon:
    """A lamp as the beacons file tells it.

    Attributes:
        id: that it plays.
        xyz: its centre in the map frame [m].
        radius: of its bright disc [m].
        frequency: that it plays instead of an ID [Hz], None for a lamp that plays its ID.
    """

    id: int
    xyz: tuple[float, float, float]
    radius: float
    frequency: float | None = None
