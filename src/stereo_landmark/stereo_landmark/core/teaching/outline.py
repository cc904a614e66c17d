"""Outlines of primitives as polylines."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.parallel_lines import ParallelLines
from stereo_landmark.core.primitives.primitive import Primitive
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral

_STEPS = 48
"""Number of segments of an ellipse."""


def primitive_outline(primitive: Primitive) -> list[NDArray[np.float64]]:
    """Return the polylines of a primitive, each of shape (n, 2) [px]."""
    match primitive:
        case Ellipse():
            angles = np.linspace(0.0, math.tau, _STEPS + 1)
            cos, sin = math.cos(primitive.tilt), math.sin(primitive.tilt)
            along = primitive.semi_axes[0] * np.cos(angles)
            across = primitive.semi_axes[1] * np.sin(angles)
            turned = np.column_stack([cos * along - sin * across, sin * along + cos * across])
            return [primitive.centre + turned]
        case Quadrilateral():
            return [np.vstack([primitive.corners, primitive.corners[:1]])]
        case ParallelLines():
            return list(primitive.lines)
        case Corner():
            ends = primitive.vertex + primitive.arms * primitive.arm_lengths[:, None]
            return [np.array([ends[0], primitive.vertex, ends[1]])]


def bounding_box(primitive: Primitive) -> NDArray[np.float64]:
    """Return the upper left and lower right corner of a primitive's bounding box, shape (2, 2) [px]."""
    points = np.vstack(primitive_outline(primitive))
    return np.array([points.min(axis=0), points.max(axis=0)])
