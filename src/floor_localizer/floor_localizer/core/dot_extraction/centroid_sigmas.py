"""Standard deviations of centroids: noise, shape, illumination, touching dots, and dots that cannot be separated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floor_localizer.core.dot_extraction.centroids import Blobs
from floor_localizer.core.dot_extraction.noise_removal import excess_edge_asymmetry

# Error without noise: ragged edges and unevenly coloured chips, for an edge as wide as the dot [px].
_SHAPE_SIGMA = 0.006
_LARGEST_SOFTNESS = 0.9
# Floor texture and compression noise are correlated between neighbours: over a wide soft edge they add up.
_SOFT_NOISE = 1.3
# Error of two touching dots: the pixels between them cannot be assigned [diameters].
_SPLIT_SIGMA = 0.02
# Error of the background under a luminance step: of second order while the step is small.
_STEP_SIGMA = 0.1
_STEP_GROWTH = 0.3
# Elongated blobs above Tukey's fence of the log area (upper quartile plus this number of interquartile ranges) may be
# two merged dots: then the centroid is between their centres.
_MERGED_FENCE = 0.5
_MERGED_ELONGATION = 1.2
_MERGED_SIGMA = 0.17
_FEWEST_BLOBS = 8


def centroid_sigmas(
    blobs: Blobs, elongations: NDArray[np.float64], split: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return the standard deviations of the centroids of dots along each axis, shape (n,) [px].

    Args:
        blobs: the dots, n of them.
        elongations: shape (n,), ratios of length to width, corrected for motion blur.
        split: shape (n,), whether each dot was split from a larger blob.
    """
    diameters = blobs.diameters
    in_diameters = split * _SPLIT_SIGMA**2 + _are_probably_merged(blobs, elongations) * _MERGED_SIGMA**2
    in_diameters += (blobs.steps * np.minimum(_STEP_SIGMA, _STEP_GROWTH * blobs.steps)) ** 2
    noise = blobs.noises * np.maximum(1.0, _SOFT_NOISE * blobs.softness)
    shape = _SHAPE_SIGMA * np.minimum(_LARGEST_SOFTNESS, blobs.softness)
    return np.sqrt(noise**2 + shape**2 + excess_edge_asymmetry(blobs) ** 2 + in_diameters * diameters**2)


def _are_probably_merged(blobs: Blobs, elongations: NDArray[np.float64]) -> NDArray[np.bool_]:
    if len(blobs.areas) < _FEWEST_BLOBS:
        return np.zeros(len(blobs.areas), dtype=np.bool_)
    lower, upper = np.quantile(blobs.areas, [0.25, 0.75])
    fence = upper * (upper / lower) ** _MERGED_FENCE
    return np.asarray((blobs.areas > fence) & (elongations > _MERGED_ELONGATION))
