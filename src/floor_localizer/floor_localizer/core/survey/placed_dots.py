"""Project observations to the map and estimate the dots from them.

A ray d of an image with the state x, y, yaw, scale, roll, pitch meets the floor at p(state, d). A dot is the weighted
mean of its observations, robust against outliers (Huber), or its fixed position.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.sighting_blocks import SightingBlock

_HUBER = 2.5


def map_points(
    directions: NDArray[np.float64], position: NDArray[np.float64], states: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the intersections p(state, d) of rays with the floor in the map frame, shape (n, 2) [m].

    Args:
        directions: ray directions in the base frame of the level robot, shape (n, 3).
        position: optical centre of the camera of the level robot, shape (3,) [m].
        states: state of the image of each ray, shape (n, 6).
    """
    x, y, yaw, scale, roll, pitch = states.T
    d = _tilted(directions.T, roll, pitch)
    o = _tilted(np.broadcast_to(position[:, None], d.shape), roll, pitch)
    reach = -(o[2] + position[2] * scale) / d[2]
    px, py = o[0] + reach * d[0], o[1] + reach * d[1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.column_stack([x + cos * px - sin * py, y + sin * px + cos * py])


def _tilted(
    vectors: NDArray[np.float64], roll: NDArray[np.float64], pitch: NDArray[np.float64]
) -> NDArray[np.float64]:
    x, y, z = vectors
    y, z = np.cos(roll) * y - np.sin(roll) * z, np.sin(roll) * y + np.cos(roll) * z
    return np.stack([np.cos(pitch) * x + np.sin(pitch) * z, y, np.cos(pitch) * z - np.sin(pitch) * x])


def place_dots(
    block: SightingBlock, states: NDArray[np.float64], position: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the dots of a block, shape (m, 2), and the residuals of its observations, shape (n, 2) [m]."""
    points = map_points(block.seen.directions, position, states[block.seen.image])
    dots = weighted_dots(block, points, huber_weights(block, points))
    return dots, points - dots[block.seen.dot]


def weighted_dots(
    block: SightingBlock, points: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the weighted means of the observations of each dot; fixed dots keep their position."""
    dot, number = block.seen.dot, len(block.fixed_dots)
    total = np.maximum(np.bincount(dot, weights, number), 1e-30)
    means = np.column_stack([np.bincount(dot, weights * points[:, k], number) / total for k in range(2)])
    return np.where(block.is_fixed[:, None], block.fixed_dots, means)


def huber_weights(block: SightingBlock, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Huber weights divided by the variances, shape (n,)."""
    seen = block.seen
    dots = weighted_dots(block, points, 1.0 / seen.sigmas**2)
    length = np.hypot(*(points - dots[seen.dot]).T) / seen.sigmas
    return np.minimum(1.0, _HUBER / np.maximum(length, 1e-12)) / seen.sigmas**2
