"""The motion along an arc, exact for any turn."""

from __future__ import annotations

import math

import numpy as np

from shirube_geometry import PlanarPose


def arc_motion(way: float, turn: float) -> PlanarPose:
    """Return the pose after an arc in the frame of its start.

    Args:
        way: length of the arc, forward positive [m].
        turn: turn along it, counter-clockwise positive [rad].
    """
    chord = way * float(np.sinc(0.5 * turn / math.pi))
    return PlanarPose(chord * math.cos(0.5 * turn), chord * math.sin(0.5 * turn), turn)
