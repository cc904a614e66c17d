"""Exact motion along an arc."""

from __future__ import annotations

import math

import numpy as np

from shirube_core.geometry import SE2


def arc_motion(distance: float, yaw: float) -> SE2:
    """Return the pose after an arc in the frame of its start.

    Args:
        distance: length of the arc, forward positive [m].
        yaw: yaw change along the arc, counter-clockwise positive [rad].
    """
    chord = distance * float(np.sinc(0.5 * yaw / math.pi))
    return SE2(chord * math.cos(0.5 * yaw), chord * math.sin(0.5 * yaw), yaw)
