"""Small floors for the tests of maps."""

import math

import numpy as np

from floor_localizer.core.dots import DotMap

DENSITY = 5384.0


def random_map(seed: int, size: tuple[float, float] = (0.4, 0.3)) -> DotMap:
    """Dots as dense as the paper's, all at least a millimetre apart, in whole micrometres."""
    rng = np.random.default_rng(seed)
    points, count = np.empty((math.ceil(DENSITY * size[0] * size[1]), 2)), 0
    while count < len(points):
        point = np.round(rng.uniform((0.0, 0.0), size), 6)
        if not count or np.hypot(*(points[:count] - point).T).min() > 0.001:
            points[count] = point
            count += 1
    return DotMap(points, np.round(rng.uniform(0.002, 0.003, count), 6))
