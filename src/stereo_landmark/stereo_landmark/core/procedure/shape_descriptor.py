"""Shapes as numbers: two primitives of a kind look the same where all of these differ by less than one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.primitives.corner import Corner
from stereo_landmark.core.primitives.ellipse import Ellipse
from stereo_landmark.core.primitives.parallel_lines import ParallelLines
from stereo_landmark.core.primitives.quadrilateral import Quadrilateral
from stereo_landmark.core.procedure.primitive import Primitive

DESCRIPTORS = 9
SIZE_STEP = 0.2
"""Difference of the logarithm of a size between the views of both cameras."""
ANGLE_STEP = 0.2
"""Difference of a direction [rad]."""
CORNER_STEP = 0.15
"""Difference of the corner of a quadrilateral as a part of its size."""
LENGTH_STEP = 0.7
"""Difference of the logarithm of a length whose ends are badly known."""


def descriptor_of(primitive: Primitive) -> NDArray[np.float64]:
    """Return the numbers of a primitive, shape (DESCRIPTORS,)."""
    numbers = np.zeros(DESCRIPTORS)
    match primitive:
        case Ellipse():
            flatness = 1.0 - primitive.semi_axes[1] / primitive.semi_axes[0]
            numbers[:2] = np.log(primitive.semi_axes) / SIZE_STEP
            numbers[2:4] = _line(primitive.tilt) * flatness / ANGLE_STEP
            numbers[4] = 2.0 * primitive.polarity
        case Quadrilateral():
            size = float(np.linalg.norm(primitive.corner_vectors)) / 2.0
            numbers[:8] = primitive.corner_vectors.ravel() / (size * CORNER_STEP)
            numbers[8] = math.log(size) / SIZE_STEP + 100.0 * primitive.polarity
        case ParallelLines():
            numbers[0] = math.log(primitive.width) / SIZE_STEP
            numbers[1:3] = _line(primitive.tilt) / ANGLE_STEP
            numbers[3] = math.log(primitive.length) / LENGTH_STEP
            numbers[4] = 2.0 * primitive.polarity
        case Corner():
            numbers[0] = primitive.angle / ANGLE_STEP
            numbers[1:3] = np.array([math.cos(primitive.bisector), math.sin(primitive.bisector)]) / ANGLE_STEP
            numbers[3] = 2.0 * primitive.polarity
    return numbers


def _line(tilt: float) -> NDArray[np.float64]:
    """Return a direction without a sense as half the unit vector of twice its angle, shape (2,)."""
    return 0.5 * np.array([math.cos(2.0 * tilt), math.sin(2.0 * tilt)])
