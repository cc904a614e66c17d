"""A lamp at a known position."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Beacon:
    """A lamp of the beacons file.

    Attributes:
        id: transmitted ID.
        xyz: position of its centre in the map frame [m].
        radius: radius of its bright disc [m].
        frequency: constant tone sent instead of an ID [Hz], None for a lamp that sends its ID.
    """

    id: int
    xyz: tuple[float, float, float]
    radius: float
    frequency: float | None = None
