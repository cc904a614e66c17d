"""Points whose distances to the others are not the taught ones are left out (paper 3.4, end)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stereo_landmark.core.place.stereo_points import SpatialPoints

GATE_SIGMAS = 4.0
DISTANCE_ERROR = 0.002
"""Distances change by about this without anything being wrong: the light, the view, what is taken for a centre [m]."""


def consistent_points(found: SpatialPoints, taught: SpatialPoints) -> NDArray[np.bool_]:
    """Return which points keep their distances to each other, shape (n,).

    As long as some distance is wrong, the point with most wrong ones goes; of several, the one that is farthest off. Of
    two points that disagree nobody knows which is wrong: both go.

    Args:
        found: n points as measured now, in any frame.
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
    """Return how many standard deviations each distance is off, shape (n, n)."""
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
