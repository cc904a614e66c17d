"""Project observations to the map and estimate the dots from them.

A ray d of an image with the state x, y, yaw, scale, roll, pitch meets the floor at p(state, d). A dot is the weighted
mean of its observations, robust against outliers (Huber), or its fixed position.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.survey.observation_blocks import ObservationBlock

_HUBER = 2.5


def project_rays_to_map(
    directions: NDArray[np.float64], position: NDArray[np.float64], states: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the intersections p(state, d) of rays with the floor in the map frame, shape (n, 2) [m].

    Args:
        directions: ray directions in the base frame of the level robot, shape (n, 3).
        position: optical centre of the camera of the level robot, shape (3,) [m].
        states: state of the image of each ray, shape (n, 6).
    """
    x, y, yaw, scale, roll, pitch = states.T
    d = _tilt(directions.T, roll, pitch)
    o = _tilt(np.broadcast_to(position[:, None], d.shape), roll, pitch)
    ray_length = -(o[2] + position[2] * scale) / d[2]
    px, py = o[0] + ray_length * d[0], o[1] + ray_length * d[1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.column_stack([x + cos * px - sin * py, y + sin * px + cos * py])


def _tilt(
    vectors: NDArray[np.float64], roll: NDArray[np.float64], pitch: NDArray[np.float64]
) -> NDArray[np.float64]:
    x, y, z = vectors
    y, z = np.cos(roll) * y - np.sin(roll) * z, np.sin(roll) * y + np.cos(roll) * z
    return np.stack([np.cos(pitch) * x + np.sin(pitch) * z, y, np.cos(pitch) * z - np.sin(pitch) * x])


def estimate_dots(
    block: ObservationBlock, states: NDArray[np.float64], position: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the dots of a block, shape (m, 2), and the residuals of its observations, shape (n, 2) [m]."""
    points = project_rays_to_map(block.observations.directions, position, states[block.observations.image])
    dots = weighted_means(block, points, huber_weights(block, points))
    return dots, points - dots[block.observations.dot]


def weighted_means(
    block: ObservationBlock, points: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the weighted means of the observations of each dot; fixed dots keep their position."""
    dot, number = block.observations.dot, len(block.fixed_dots)
    total = np.maximum(np.bincount(dot, weights, number), 1e-30)
    means = np.column_stack([np.bincount(dot, weights * points[:, k], number) / total for k in range(2)])
    return np.where(block.is_fixed[:, None], block.fixed_dots, means)


def huber_weights(block: ObservationBlock, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Huber weights divided by the variances, shape (n,)."""
    observations = block.observations
    dots = weighted_means(block, points, 1.0 / observations.sigmas**2)
    length = np.hypot(*(points - dots[observations.dot]).T) / observations.sigmas
    return np.minimum(1.0, _HUBER / np.maximum(length, 1e-12)) / observations.sigmas**2
