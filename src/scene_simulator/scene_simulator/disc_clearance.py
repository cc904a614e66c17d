"""Clearance of a vertical cylinder from all obstacles in a room."""

from __future__ import annotations

import math

from scene_simulator.box_room import BoxRoom


def disc_clearance(room: BoxRoom, x: float, y: float, radius: float, height: float) -> float:
    """Return the clearance between a cylinder and the nearest box or wall [m]; 0 or less in contact.

    Args:
        room: the room; boxes that begin above the cylinder do not count.
        x: x of the cylinder's axis in the map frame [m].
        y: the same [m].
        radius: cylinder radius [m].
        height: cylinder height above the floor [m].
    """
    x0, y0, floor, x1, y1, _ = room.size
    nearest = min(x - x0, x1 - x, y - y0, y1 - y)
    for left, low, bottom, right, high, _ in room.boxes:
        if bottom < floor + height:
            distance = math.hypot(max(left - x, 0.0, x - right), max(low - y, 0.0, y - high))
            nearest = min(nearest, distance)
    return nearest - radius
