"""Exact motion along an arc."""

from __future__ import annotations

import math

import numpy as np

from shirube_geometry import PlanarPose


def arc_motion(distance: float, yaw: float) -> PlanarPose:
    """Return the pose after an arc in the frame of its start.

    Args:
        distance: length of the arc, forward positive [m].
        yaw: yaw change along the arc, counter-clockwise positive [rad].
    """
    chord = distance * float(np.sinc(0.5 * yaw / math.pi))
    return PlanarPose(chord * math.cos(0.5 * yaw), chord * math.sin(0.5 * yaw), yaw)
