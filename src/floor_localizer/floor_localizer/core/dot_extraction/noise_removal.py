"""Noise removal (paper 3.1): rejects hairs, specks and reflections; and how accurate the centroids of dots are."""

import numpy as np

from floor_localizer.core.arrays import Booleans, Floats
from floor_localizer.core.dot_extraction.centroids import Blobs
from floor_localizer.core.settings import DotDetectorSettings

_MAX_CLIPPED_FRACTION = 0.05
# Minimum ratio of contrast to luminance step; the edge of a shadow has a ratio up to 1.
_LEAST_CONTRAST_TO_STEP = 1.3
# Maximum edge asymmetry of a dot, the offset between the weak and the strong part of its edge [diameters].
_MAX_EDGE_ASYMMETRY = 0.25
# Edge asymmetry due to ragged outlines [diameters] and due to noise [standard deviations].
_RAGGED_EDGE_ASYMMETRY = 0.04
_EDGE_ASYMMETRY_SIGMAS = 3.0
# Minimum number of blobs for statistics over them.
_FEWEST_BLOBS = 8
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


def typical_diameter(
    areas: Floats, smallest: float, largest: float, contrasts: Floats | float = 1.0
) -> float:
    """Return the area-weighted median diameter of the blobs of a dot's size (smallest to largest diameter) [px].

    It is robust to specks, which are many but small, and to wet spots, which are large but have little contrast: the
    squares of the contrasts are additional weights.
    """
    diameters = 2.0 * np.sqrt(areas / np.pi)
    order = np.argsort(diameters)
    weights = (areas * np.square(contrasts))[order]
    diameters = diameters[order]
    weights[(diameters < smallest) | (diameters > largest)] = 0.0
    covered = np.cumsum(weights)
    if len(diameters) == 0 or covered[-1] == 0.0:
        return smallest
    return float(diameters[np.searchsorted(covered, 0.5 * covered[-1])])


def are_dots(blobs: Blobs, elongations: Floats, largest: float, settings: DotDetectorSettings) -> Booleans:
    """Return which blobs are dots, not dirt or reflections, shape (n,), given their `blob_elongations`."""
    diameters = blobs.diameters
    accepted = (diameters >= settings.minimum_diameter) & (diameters <= largest) & (blobs.contrasts > 0.0)
    typical = typical_diameter(blobs.areas, settings.minimum_diameter, largest, blobs.contrasts)
    accepted &= diameters >= settings.minimum_relative_diameter * typical
    accepted &= blobs.contrasts > _LEAST_CONTRAST_TO_STEP * blobs.steps
    accepted &= excess_edge_asymmetry(blobs) <= _MAX_EDGE_ASYMMETRY * diameters
    accepted &= elongations <= settings.maximum_elongation
    return accepted & ~_reflections(blobs.clipped, accepted)


def excess_edge_asymmetry(blobs: Blobs) -> Floats:
    """Return the edge asymmetries in excess of those from ragged outlines and noise, at least 0, shape (n,) [px]."""
    explained = _RAGGED_EDGE_ASYMMETRY * blobs.diameters + _EDGE_ASYMMETRY_SIGMAS * blobs.noises
    return np.asarray(np.maximum(0.0, blobs.edge_asymmetries - explained))


def blob_elongations(blobs: Blobs) -> Floats:
    """Return the ratios of the blobs' lengths to their widths, corrected for motion blur, shape (n,)."""
    # Motion blur elongates all dots equally: shapes are compared with the median shape, not with a disc.
    uu, uv, vv = blobs.covariances.T
    common = np.array([1.0, 0.0, 1.0])
    measured = blobs.contrasts > 0.0
    if np.count_nonzero(measured) >= _FEWEST_BLOBS:
        common = np.median(blobs.covariances[measured], axis=0)
    a, b, c = common / np.sqrt(max(common[0] * common[2] - common[1] ** 2, 1e-12))
    half_trace = 0.5 * (c * uu - 2.0 * b * uv + a * vv)
    determinant = np.maximum(uu * vv - uv**2, 1e-12)
    root = np.sqrt(np.maximum(half_trace**2 - determinant, 0.0))
    return np.asarray((half_trace + root) / np.sqrt(determinant), dtype=np.float64)


def _reflections(clipped: Floats, candidates: Booleans) -> Booleans:
    # If most dots are clipped, the image is overexposed; these are no reflections.
    if not candidates.any() or np.median(clipped[candidates]) > _MAX_CLIPPED_FRACTION:
        return np.zeros(len(clipped), dtype=np.bool_)
    return clipped > _MAX_CLIPPED_FRACTION


def centroid_sigmas(blobs: Blobs, elongations: Floats, split: Booleans) -> Floats:
    """Return the standard deviations of the centroids of dots along each axis, shape (n,) [px].

    ``elongations`` are their `blob_elongations`; ``split`` tells which were split from a larger blob.
    """
    diameters = blobs.diameters
    in_diameters = split * _SPLIT_SIGMA**2 + _are_probably_merged(blobs, elongations) * _MERGED_SIGMA**2
    in_diameters += (blobs.steps * np.minimum(_STEP_SIGMA, _STEP_GROWTH * blobs.steps)) ** 2
    noise = blobs.noises * np.maximum(1.0, _SOFT_NOISE * blobs.softness)
    shape = _SHAPE_SIGMA * np.minimum(_LARGEST_SOFTNESS, blobs.softness)
    return np.sqrt(noise**2 + shape**2 + excess_edge_asymmetry(blobs) ** 2 + in_diameters * diameters**2)


def _are_probably_merged(blobs: Blobs, elongations: Floats) -> Booleans:
    if len(blobs.areas) < _FEWEST_BLOBS:
        return np.zeros(len(blobs.areas), dtype=np.bool_)
    lower, upper = np.quantile(blobs.areas, [0.25, 0.75])
    fence = upper * (upper / lower) ** _MERGED_FENCE
    return np.asarray((blobs.areas > fence) & (elongations > _MERGED_ELONGATION))
