"""Small floors for the tests of maps."""

from __future__ import annotations

import numpy as np

from floor_localizer.core.dot_map import DotMap

DENSITY = 5384.0


def random_map(seed: int, size: tuple[float, float] = (0.4, 0.3)) -> DotMap:
    """Dots as dense as the paper's, all at least a millimetre apart, in whole micrometres."""
    rng = np.random.default_rng(seed)
    points: list[np.ndarray] = []
    while len(points) < DENSITY * size[0] * size[1]:
        point = np.round(rng.uniform((0.0, 0.0), size), 6)
        if not points or np.min(np.hypot(*(np.array(points) - point).T)) > 0.001:
            points.append(point)
    return DotMap(np.array(points), np.round(rng.uniform(0.002, 0.003, len(points)), 6))
