"""Where two lines meet, and how well that is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def crossing_covariance(
    vertices: NDArray[np.float64],
    middles: NDArray[np.float64],
    directions: NDArray[np.float64],
    variances: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the covariances of crossings of two lines each, shape (n, 2, 2) [px²].

    Each line is known across itself at its middle and by its direction: at the vertex its offset has the
    variance of both together, and the two offsets give the place.

    Args:
        vertices: shape (n, 2) [px].
        middles: shape (n, 2, 2), a point of each line where its offset and direction are independent [px].
        directions: shape (n, 2, 2), unit vectors.
        variances: shape (n, 2, 2), of the offset [px²] and of the direction [rad²] of each line.
    """
    arms = np.sum((vertices[:, None] - middles) * directions, axis=2)
    offsets = variances[..., 0] + arms**2 * variances[..., 1]
    normals = np.stack([-directions[..., 1], directions[..., 0]], axis=2)
    inverse = np.linalg.inv(normals)
    return np.asarray(inverse * offsets[:, None, :] @ inverse.transpose(0, 2, 1), dtype=np.float64)
