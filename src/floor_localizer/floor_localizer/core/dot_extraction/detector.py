"""Dot detector, in the steps of the paper (3.1), and the noise removal among them.

Noise removal rejects hairs, specks and reflections, and tells how accurate the centroids of dots are.
"""

import cv2
import numpy as np

from floor_localizer.core.arrays import Booleans, Floats, Pixels
from floor_localizer.core.dot_extraction.binarisation import (
    binarise,
    choose_polarity,
    contrast_threshold,
    smooth_background,
    upsample,
)
from floor_localizer.core.dot_extraction.centroids import Blobs, measure_blobs
from floor_localizer.core.dot_extraction.labelling import grow_labels, label_blobs
from floor_localizer.core.dot_extraction.splitting import split_touching
from floor_localizer.core.dots import DetectedDots
from floor_localizer.core.errors import DotImageError
from floor_localizer.core.settings import DotDetectorSettings
from shirube_core.settings import SettingsError, check_settings

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


def typical_diameter(areas: Floats, smallest: float, largest: float, contrasts: Floats | float = 1.0) -> float:
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


SMALLEST_SIDE = 32  # minimum side of an image [px]
SPECK_AREA_FRACTION = 0.5  # minimum area of a blob, as a fraction of the smallest dot's area; smaller blobs are noise
MIN_PART_DIAMETER = 0.55
"""Minimum diameter of a dot split from a blob, as a fraction of the typical dot's diameter; hairs are thinner."""


class DotDetector:
    """Detects the dots in images of a floor."""

    def __init__(self, settings: DotDetectorSettings | None = None) -> None:
        """Create a detector.

        Args:
            settings: settings of dot extraction, None for the defaults.

        Raises:
            SettingsError: a setting is outside its range.
        """
        self.settings = settings or DotDetectorSettings()
        check_settings(self.settings)
        smallest, largest = self.settings.minimum_diameter, self.settings.maximum_diameter
        if 0.0 < largest <= smallest:
            raise SettingsError(
                f'setting maximum_diameter is {largest:g} px, it must be more than '
                f'minimum_diameter ({smallest:g} px), or 0'
            )

    def detect(self, image: Pixels) -> DetectedDots:
        """Detect the dots of one image.

        Args:
            image: shape (h, w) grey or (h, w, 3) blue, green, red; uint8; not modified.

        Returns:
            the dots in raw image coordinates, in arbitrary order; none on an empty floor.

        Raises:
            DotImageError: the image is of another type or shape, or too small.
        """
        check_image(image)
        height, width = image.shape[:2]
        smallest, largest = self.settings.minimum_diameter, self.settings.largest_diameter(width, height)
        image, polarity = self._select_channels(image, largest)
        smooth = cv2.GaussianBlur(image, (5, 5), 1.0).reshape(image.shape)

        background = smooth_background(smooth, polarity, largest)
        threshold = contrast_threshold(smooth, background, polarity, self.settings)
        mask = binarise(smooth, background, polarity, threshold)
        background = upsample(background, width, height)
        labels, boxes = label_blobs(mask, SPECK_AREA_FRACTION * 0.25 * np.pi * smallest**2)
        typical = typical_diameter(boxes[:, 4].astype(np.float64), smallest, largest)
        boxes, split = split_touching(
            labels, boxes, image, background, polarity, max(smallest, MIN_PART_DIAMETER * typical), largest
        )

        grow_labels(labels, boxes)
        blobs = measure_blobs(image, background, mask, labels, boxes)
        elongations = blob_elongations(blobs)
        kept = are_dots(blobs, elongations, largest, self.settings)
        blobs = Blobs(*(column[kept] for column in blobs))
        sigmas = centroid_sigmas(blobs, elongations[kept], split[kept])
        return DetectedDots(blobs.pixels, blobs.diameters, sigmas)

    def _select_channels(self, image: Pixels, largest: float) -> tuple[Pixels, str]:
        # The image as (h, w, 1) if brightness distinguishes the dots, else as (h, w, 3); and the polarity.
        polarity = self.settings.polarity
        planes = np.ascontiguousarray(image).reshape(*image.shape[:2], -1)
        if polarity == 'auto':
            polarity = choose_polarity(planes, largest)
        if planes.shape[2] == 3 and polarity != 'any':
            planes = cv2.cvtColor(planes, cv2.COLOR_BGR2GRAY)[..., None]
        return planes, polarity


def check_image(image: Pixels) -> None:
    """Check an image; raise a DotImageError that names its type, shape or size and what is expected."""
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8:
        kind = f'{image.dtype} values' if isinstance(image, np.ndarray) else type(image).__name__
        raise DotImageError(f'the image holds {kind}, it must be an array of uint8 (mono8 or bgr8)')
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3):
        raise DotImageError(f'the image has the shape {image.shape}, it must be (h, w) or (h, w, 3) (mono8 or bgr8)')
    if min(image.shape[:2]) < SMALLEST_SIDE:
        raise DotImageError(
            f'the image is {image.shape[1]} x {image.shape[0]} px, each side must be at least {SMALLEST_SIDE} px'
        )
