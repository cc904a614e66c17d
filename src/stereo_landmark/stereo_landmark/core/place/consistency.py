"""Rejects points whose distances to the others differ from the taught ones (paper 3.4, end)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import SpatialPoints

GATE_SIGMAS = 4.0
DISTANCE_ERROR = 0.002
"""Systematic error of a distance, from illumination, viewpoint and the detected centre [m]."""


def consistent_points(found: SpatialPoints, taught: SpatialPoints) -> NDArray[np.bool_]:
    """Return the mask of points with consistent pairwise distances, shape (n,).

    While some distance is inconsistent, the point with the most inconsistent distances is rejected; in a tie, the one
    with the largest error. If only two points are left and disagree, both are rejected.

    Args:
        found: n current points in any frame.
        taught: the same points as taught, in the same order, in any frame.
    """
    errors = _distance_errors(found, taught)
    kept = np.ones(len(found), dtype=np.bool_)
    while kept.any():
        wrong = (errors > GATE_SIGMAS) & kept & kept[:, None]
        counts = wrong.sum(axis=1)
        if not counts.any():
            break
        worst = np.flatnonzero(counts == counts.max())
        if counts.max() == 1 and kept.sum() == 2:
            kept[:] = False
            break
        sums = np.where(wrong, errors, 0.0).sum(axis=1)
        kept[worst[np.argmax(sums[worst])]] = False
    return kept


def _distance_errors(found: SpatialPoints, taught: SpatialPoints) -> NDArray[np.float64]:
    """Return the error of each distance in standard deviations, shape (n, n)."""
    (lengths, spreads), (taught_lengths, taught_spreads) = _distances(found), _distances(taught)
    spread = np.sqrt(spreads + taught_spreads + DISTANCE_ERROR**2)
    return np.asarray(np.abs(lengths - taught_lengths) / spread)


def _distances(points: SpatialPoints) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances [m] and their variances [m²], both of shape (n, n)."""
    offsets = points.positions[:, None] - points.positions[None]
    lengths = np.linalg.norm(offsets, axis=2)
    along = offsets / np.maximum(lengths, 1e-9)[:, :, None]
    covariances = points.covariances[:, None] + points.covariances[None]
    return lengths, np.einsum('ijk,ijkl,ijl->ij', along, covariances, along)
