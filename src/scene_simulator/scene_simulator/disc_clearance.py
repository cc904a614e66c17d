"""How far an upright cylinder is from everything solid in a room."""

from __future__ import annotations

import math

from scene_simulator.box_room import BoxRoom


def disc_clearance(room: BoxRoom, x: float, y: float, radius: float, height: float) -> float:
    """Return the room between a cylinder's rim and the nearest box or wall [m]; not above 0 where it touches one.

    Args:
        room: the room; boxes that begin above the cylinder do not count.
        x: of the cylinder's axis in the map frame [m].
        y: the same [m].
        radius: of the cylinder [m].
        height: of the cylinder, which stands on the floor [m].
    """
    x0, y0, floor, x1, y1, _ = room.size
    nearest = min(x - x0, x1 - x, y - y0, y1 - y)
    for left, low, bottom, right, high, _ in room.boxes:
        if bottom < floor + height:
            away = math.hypot(max(left - x, 0.0, x - right), max(low - y, 0.0, y - high))
            nearest = min(nearest, away)
    return nearest - radius
