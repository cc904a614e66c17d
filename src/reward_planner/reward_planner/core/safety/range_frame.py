"""One measurement of a range sensor as rays in the base frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

POINTS_MAX = 20_000
"""Denser measurements are thinned: enough for a leg at 4 m, and single wrong points stay rare."""


@dataclass(frozen=True)
class RangeFrame:
    """Rays from the sensor to what they hit, or as far as they hit nothing.

    Attributes:
        origin: position of the sensor in the base frame, shape (3,) [m].
        ends: ends of the rays in the base frame, shape (n, 3) [m], finite.
        is_hit: whether a ray ends on a surface, shape (n,).
    """

    origin: NDArray[np.float64]
    ends: NDArray[np.float64]
    is_hit: NDArray[np.bool_]


def range_frame(
    points: NDArray[np.float32],
    is_hit: NDArray[np.bool_],
    R_base_sensor: NDArray[np.float64],
    origin: NDArray[np.float64],
) -> RangeFrame:
    """Return the frame of ray ends in the sensor frame, shape (n, 3) [m]; rays that are not finite are unknown."""
    # An odd stride visits all columns of an image in turn.
    stride = -(-len(points) // POINTS_MAX) | 1 if len(points) > POINTS_MAX else 1
    thin, hit = points[::stride], is_hit[::stride]
    finite = np.isfinite(thin).all(axis=1)
    ends = thin[finite].astype(np.float64) @ R_base_sensor.T + origin
    return RangeFrame(origin, ends, hit[finite])
