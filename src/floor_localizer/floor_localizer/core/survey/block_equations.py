"""The normal equations of the images of a block; its dots are eliminated (Schur complement).

The Jacobian of a residual by its dot is the identity, so each dot is the weighted mean of its observations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from floor_localizer.core.survey.dot_estimation import huber_weights, project_rays_to_map, weighted_means
from floor_localizer.core.survey.normal_equations import UNKNOWNS_PER_IMAGE, NormalEquations, unknown_indices
from floor_localizer.core.survey.observation_blocks import ObservationBlock

_STEP = 1e-6


def block_equations(
    block: ObservationBlock, states: NDArray[np.float64], position: NDArray[np.float64]
) -> NormalEquations:
    """Return the normal equations of a block, without its dots.

    Args:
        block: the observations.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
    """
    observations, number = block.observations, len(block.fixed_dots)
    images, image = np.unique(observations.image, return_inverse=True)
    image_states = states[observations.image]
    points = project_rays_to_map(observations.directions, position, image_states)
    weights = huber_weights(block, points)
    residuals = points - weighted_means(block, points, weights)[observations.dot]
    jacobian = _jacobian(observations.directions, position, points, image_states)
    # The noise is in the image, so it grows on the floor with the camera height. Without this term the map would
    # shrink to reduce its residuals.
    jacobian[:, :, 3] -= residuals
    weighted = (jacobian * weights[:, None, None]).ravel()
    columns = np.repeat(unknown_indices(image).reshape(-1, 1, UNKNOWNS_PER_IMAGE), 2, axis=1).ravel()
    rows = np.repeat(np.arange(2 * len(image)), UNKNOWNS_PER_IMAGE)
    dot_rows = np.repeat((2 * observations.dot[:, None] + np.arange(2)).ravel(), UNKNOWNS_PER_IMAGE)
    size = UNKNOWNS_PER_IMAGE * len(images)
    J = sparse.csr_matrix((jacobian.ravel(), (rows, columns)), shape=(2 * len(image), size))
    WJ = sparse.csr_matrix((weighted, (rows, columns)), shape=(2 * len(image), size))
    dot_projection = sparse.csr_matrix((weighted, (dot_rows, columns)), shape=(2 * number, size))
    total = np.bincount(observations.dot, weights, number)
    free = np.where(block.is_fixed | (total == 0.0), 0.0, 1.0 / np.maximum(total, 1e-30))
    normal = J.T @ WJ - dot_projection.T @ sparse.diags(np.repeat(free, 2)) @ dot_projection
    # The weighted residuals of a free dot sum to 0, so the gradient needs no term for the dots.
    return NormalEquations(images, normal.toarray(), np.asarray(WJ.T @ residuals.ravel()))


def _jacobian(
    directions: NDArray[np.float64],
    position: NDArray[np.float64],
    points: NDArray[np.float64],
    image_states: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the derivatives of the points by the state of their image, shape (n, 2, 6), by finite differences."""
    jacobian = np.empty((len(points), 2, UNKNOWNS_PER_IMAGE))
    for unknown in range(UNKNOWNS_PER_IMAGE):
        stepped = image_states.copy()
        stepped[:, unknown] += _STEP
        jacobian[:, :, unknown] = (project_rays_to_map(directions, position, stepped) - points) / _STEP
    return jacobian
