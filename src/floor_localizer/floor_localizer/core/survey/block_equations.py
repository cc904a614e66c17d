"""The normal equations of the images of a block; its dots are eliminated (Schur complement).

The Jacobian of a residual by its dot is the identity, so each dot is the weighted mean of its observations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from floor_localizer.core.survey.equations import UNKNOWNS, Equations, unknowns_of
from floor_localizer.core.survey.placed_dots import huber_weights, map_points, weighted_dots
from floor_localizer.core.survey.sighting_blocks import SightingBlock

_STEP = 1e-6


def block_equations(
    block: SightingBlock, states: NDArray[np.float64], position: NDArray[np.float64]
) -> Equations:
    """Return the normal equations of a block, without its dots.

    Args:
        block: the observations.
        states: states of all images, shape (k, 6).
        position: optical centre in the base frame, shape (3,) [m].
    """
    seen, number = block.seen, len(block.fixed_dots)
    images, image = np.unique(seen.image, return_inverse=True)
    each = states[seen.image]
    points = map_points(seen.directions, position, each)
    weights = huber_weights(block, points)
    residuals = points - weighted_dots(block, points, weights)[seen.dot]
    jacobian = _jacobian(seen.directions, position, points, each)
    # The noise is in the image, so it grows on the floor with the camera height. Without this term the map would
    # shrink to reduce its residuals.
    jacobian[:, :, 3] -= residuals
    weighted = (jacobian * weights[:, None, None]).ravel()
    columns = np.repeat(unknowns_of(image).reshape(-1, 1, UNKNOWNS), 2, axis=1).ravel()
    rows = np.repeat(np.arange(2 * len(image)), UNKNOWNS)
    dot_rows = np.repeat((2 * seen.dot[:, None] + np.arange(2)).ravel(), UNKNOWNS)
    size = UNKNOWNS * len(images)
    J = sparse.csr_matrix((jacobian.ravel(), (rows, columns)), shape=(2 * len(image), size))
    WJ = sparse.csr_matrix((weighted, (rows, columns)), shape=(2 * len(image), size))
    M = sparse.csr_matrix((weighted, (dot_rows, columns)), shape=(2 * number, size))
    total = np.bincount(seen.dot, weights, number)
    free = np.where(block.is_fixed | (total == 0.0), 0.0, 1.0 / np.maximum(total, 1e-30))
    normal = J.T @ WJ - M.T @ sparse.diags(np.repeat(free, 2)) @ M
    # The weighted residuals of a free dot sum to 0, so the gradient needs no term for the dots.
    return Equations(images, normal.toarray(), np.asarray(WJ.T @ residuals.ravel()))


def _jacobian(
    directions: NDArray[np.float64],
    position: NDArray[np.float64],
    points: NDArray[np.float64],
    each: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the derivatives of the points by the state of their image, shape (n, 2, 6), by finite differences."""
    jacobian = np.empty((len(points), 2, UNKNOWNS))
    for unknown in range(UNKNOWNS):
        ahead = each.copy()
        ahead[:, unknown] += _STEP
        jacobian[:, :, unknown] = (map_points(directions, position, ahead) - points) / _STEP
    return jacobian
